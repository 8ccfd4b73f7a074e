// A press counts where it began: until its click, what was pressed is neither replaced nor disabled, and moves nowhere.

const LONGEST_MS = 3000; // a longer press is no click: what it holds back would grow old
const CLICK_MS = 350; // the click of a touch comes after its pointerup
const STRAY = 16; // [px] from which a pointer has left what it pressed
const CONTROLS = "button, a[href], summary";

/** @type {Element | null} */
let held = null;
/** @type {{x: number, y: number} | null} */
let from = null;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;
/** @type {Map<Element, () => void>} what is done after the click, the newest for each element */
const waiting = new Map();

/** True while a pointer holds a control of it down. @param {Element} element */
export const isPressed = (element) => held !== null && element.contains(held);

/** Change an element now, or once the press on something in it was a click. @param {Element} element @param {() => void} change */
export function unlessPressed(element, change) {
  if (isPressed(element)) waiting.set(element, change);
  else {
    waiting.delete(element);
    change();
  }
}

/** Replace the children of an element that may hold buttons. @param {Element} element @param {...(Node | string)} children */
export const refill = (element, ...children) => unlessPressed(element, () => element.replaceChildren(...children));

function release() {
  held = null;
  const changes = [...waiting.values()];
  waiting.clear();
  for (const change of changes) change();
}

/** @param {number} ms */
function releaseIn(ms) {
  clearTimeout(timer);
  timer = setTimeout(release, ms);
}

if (globalThis.document) {
  addEventListener("pointerdown", ({ target, button, pointerId, clientX, clientY }) => {
    const control = target instanceof Element && button === 0 ? target.closest(CONTROLS) : null;
    release();
    if (!control || control.hasPointerCapture(pointerId)) return; // what acts while it is held captures the pointer itself
    [held, from] = [control, { x: clientX, y: clientY }];
    control.setPointerCapture(pointerId); // the click goes to it, wherever it is by then
    releaseIn(LONGEST_MS);
  });
  addEventListener("pointermove", ({ pointerId, clientX, clientY }) => {
    if (held && from && Math.hypot(clientX - from.x, clientY - from.y) > STRAY && held.hasPointerCapture(pointerId))
      held.releasePointerCapture(pointerId);
  });
  addEventListener("pointerup", () => held && releaseIn(CLICK_MS));
  addEventListener("pointercancel", release);
  addEventListener(
    "click",
    () => {
      if (held) releaseIn(0);
      held = null; // what is pressed may change its own place
    },
    true,
  );
}

const SAME_PRESS_MS = 600; // the click that follows a touch is the same press

/** Act when a button is touched, not only when it is let go; keys click it. @param {HTMLElement} button @param {() => void} act */
export function onTouch(button, act) {
  let touchedAt = -Infinity;
  button.addEventListener("pointerdown", () => {
    touchedAt = performance.now();
    act();
  });
  button.addEventListener("click", () => performance.now() - touchedAt > SAME_PRESS_MS && act());
}
