// A comma in a field for numbers: where the browser knows the point alone it drops it, and “0,8” would be 8.

/** @param {KeyboardEvent} event */
export function takeComma(event) {
  const field = event.target;
  if (event.key !== "," || event.ctrlKey || event.metaKey || event.altKey) return;
  if (!(field instanceof HTMLInputElement) || field.type !== "number") return;
  event.preventDefault();
  let taken = false;
  const note = () => (taken = true);
  field.addEventListener("input", note);
  document.execCommand("insertText", false, ","); // into a field it keeps the history for undoing
  field.removeEventListener("input", note);
  if (!taken) document.execCommand("insertText", false, ".");
}
