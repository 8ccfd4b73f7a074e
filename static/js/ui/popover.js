// Button that opens a small panel below itself. Not modal: STOP and everything else stay reachable.

/**
 * @param {HTMLButtonElement} button
 * @param {HTMLElement} panel
 * @param {{opened?: () => void, folds?: () => boolean}} [then] `folds`: false while the panel lies open beside the page
 * @returns {{close: () => void}}
 */
export function popover(button, panel, { opened, folds = () => true } = {}) {
  panel.classList.toggle("popover", folds());
  panel.hidden = folds();
  button.setAttribute("aria-expanded", "false");
  button.setAttribute("aria-haspopup", "true");

  /** @param {boolean} open */
  const set = (open) => {
    if (panel.hidden === !open || !folds()) return;
    panel.hidden = !open;
    button.setAttribute("aria-expanded", String(open));
    if (!open) return;
    opened?.();
    keepInside(panel);
  };

  button.addEventListener("click", () => set(panel.hidden === true));
  /** @param {EventTarget | null} target */
  const outside = (target) => !(target instanceof Node) || !(panel.contains(target) || button.contains(target));
  addEventListener("pointerdown", (event) => outside(event.target) && set(false), true);
  addEventListener("blur", () => document.activeElement?.localName === "iframe" && set(false));
  panel.addEventListener("focusout", (event) => event.relatedTarget && outside(event.relatedTarget) && set(false));
  addEventListener(
    "keydown",
    (event) => {
      if (event.key !== "Escape" || panel.hidden) return;
      if (panel.contains(document.activeElement)) button.focus();
      set(false);
    },
    true,
  );
  return { close: () => set(false) };
}

/** Shift a panel sideways so that none of it lies outside the window. @param {HTMLElement} panel */
function keepInside(panel) {
  panel.style.translate = "";
  const { left, right } = panel.getBoundingClientRect();
  const over = right - (document.documentElement.clientWidth - 8);
  const shift = over > 0 ? -Math.min(over, left - 8) : Math.max(0, 8 - left);
  if (shift) panel.style.translate = `${shift}px 0`;
}
