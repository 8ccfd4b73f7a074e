// A zip of a few files, without compression.

/** @typedef {{name: string, bytes: Uint8Array<ArrayBuffer>}} Member */

const POLYNOMIAL = 0xedb88320; // of CRC-32
const TABLE = Uint32Array.from({ length: 256 }, (_, number) => {
  let rest = number;
  for (let bit = 0; bit < 8; bit += 1) rest = rest & 1 ? POLYNOMIAL ^ (rest >>> 1) : rest >>> 1;
  return rest >>> 0;
});

/** @param {Uint8Array} bytes */
export function crc32(bytes) {
  let rest = 0xffffffff;
  for (const byte of bytes) rest = (TABLE[(rest ^ byte) & 0xff] ?? 0) ^ (rest >>> 8);
  return (rest ^ 0xffffffff) >>> 0;
}

/** Numbers as bytes, the lowest first. @param {Array<[number, 2 | 4]>} fields value and number of bytes */
function packed(fields) {
  const bytes = new Uint8Array(fields.reduce((sum, [, size]) => sum + size, 0));
  const view = new DataView(bytes.buffer);
  let at = 0;
  for (const [value, size] of fields) {
    if (size === 2) view.setUint16(at, value, true);
    else view.setUint32(at, value, true);
    at += size;
  }
  return bytes;
}

/** @param {Member[]} members @returns {Blob} */
export function zipOf(members) {
  /** @type {Uint8Array<ArrayBuffer>[]} */
  const parts = [];
  /** @type {Uint8Array<ArrayBuffer>[]} */
  const index = [];
  let at = 0;
  for (const { name, bytes } of members) {
    const called = new TextEncoder().encode(name);
    /** @type {Array<[number, 2 | 4]>} version, UTF-8, stored, no date, checksum, sizes */
    const facts = [
      [20, 2],
      [0x800, 2],
      [0, 2],
      [0, 4],
      [crc32(bytes), 4],
      [bytes.length, 4],
      [bytes.length, 4],
    ]; // prettier-ignore
    /** @type {Array<[number, 2 | 4]>} */
    const sizes = [...facts, [called.length, 2], [0, 2]];
    const head = packed([[0x04034b50, 4], ...sizes]);
    parts.push(head, called, bytes);
    index.push(packed([[0x02014b50, 4], [20, 2], ...sizes, [0, 2], [0, 2], [0, 2], [0, 4], [at, 4]]), called);
    at += head.length + called.length + bytes.length;
  }
  const long = index.reduce((sum, part) => sum + part.length, 0);
  const end = packed([
    [0x06054b50, 4],
    [0, 4],
    [members.length, 2],
    [members.length, 2],
    [long, 4],
    [at, 4],
    [0, 2],
  ]);
  return new Blob([...parts, ...index, end], { type: "application/zip" });
}
