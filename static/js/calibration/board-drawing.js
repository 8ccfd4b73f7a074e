// Element <board-drawing>: chessboard whose inner corners are numbered as the operator has to count them.

import { isNew, svg } from "../ui/element.js";
import { t } from "../ui/texts.js";

/** @typedef {{columns: number, rows: number}} Counts */

const SQUARE = 10;
const ROOM = 11; // around the board, for the numbers

export class BoardDrawing extends HTMLElement {
  /** @param {Counts} counts inner corners */
  show({ columns, rows }) {
    if (!(columns > 0 && rows > 0) || !isNew(this, columns, rows)) return;
    const [width, height] = [(columns + 1) * SQUARE, (rows + 1) * SQUARE];
    const drawing = svg("svg", {
      viewBox: `${-ROOM} ${-ROOM} ${width + 1.4 * ROOM} ${height + 1.4 * ROOM}`,
      role: "img",
      "aria-label": t("board-drawing.a_board_of_columns_by_rows", {
        columns: columns + 1,
        rows: rows + 1,
        columns2: columns,
        rows2: rows,
      }),
    });
    drawing.append(svg("rect", { class: "board-paper", x: -3, y: -3, width: width + 6, height: height + 6, rx: 1.5 }));
    for (let row = 0; row <= rows; row += 1)
      for (let column = row % 2; column <= columns; column += 2)
        drawing.append(
          svg("rect", { class: "board-square", x: column * SQUARE, y: row * SQUARE, width: SQUARE, height: SQUARE }),
        );
    for (let row = 1; row <= rows; row += 1)
      for (let column = 1; column <= columns; column += 1) {
        const counted = row === 1 || column === 1;
        const place = { cx: column * SQUARE, cy: row * SQUARE, r: counted ? 2.3 : 1.5 };
        drawing.append(svg("circle", { class: counted ? "board-corner is-counted" : "board-corner", ...place }));
      }
    for (let column = 1; column <= columns; column += 1) drawing.append(number(column * SQUARE, -6.5, column, columns));
    for (let row = 1; row <= rows; row += 1) drawing.append(number(-7, row * SQUARE, row, rows));
    this.replaceChildren(drawing);
  }
}

/**
 * @param {number} x
 * @param {number} y
 * @param {number} value
 * @param {number} last the one to be entered
 */
function number(x, y, value, last) {
  const kind = value === last ? "board-number is-last" : "board-number";
  const text = svg("text", { class: kind, x, y, "text-anchor": "middle", "dominant-baseline": "central" });
  text.textContent = String(value);
  return text;
}

customElements.define("board-drawing", BoardDrawing);
