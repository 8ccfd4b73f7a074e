// Settings that this browser keeps between visits. Without storage the defaults apply.

/** @param {string} name @param {string} otherwise */
export function remembered(name, otherwise) {
  try {
    return localStorage.getItem(`beckon.${name}`) ?? otherwise;
  } catch {
    return otherwise;
  }
}

/** @param {string} name @param {string} value */
export function remember(name, value) {
  try {
    localStorage.setItem(`beckon.${name}`, value);
  } catch {
    // a private window: the choice holds for this visit
  }
}
