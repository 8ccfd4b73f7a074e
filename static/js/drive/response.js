// Response of a stick axis: dead zone around the centre, then a curve that is gentle near it.

/**
 * @param {number} part deflection −1 to 1; anything beyond counts as full, anything that is no number as centred
 * @param {number} deadZone 0 to below 1: up to here the axis counts as centred
 * @param {number} [curve] 0: straight; 1: cubic
 * @returns {number} −1 to 1, continuous and rising
 */
export function response(part, deadZone, curve = 0) {
  const size = Math.min(1, Math.abs(part));
  if (!(size > deadZone)) return 0;
  const beyond = (size - deadZone) / (1 - deadZone);
  return Math.sign(part) * ((1 - curve) * beyond + curve * beyond ** 3);
}
