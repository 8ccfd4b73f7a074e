"""A board to print, with rulers that show whether the printer kept the scale."""

from typing import Literal

from core.calibration.board.board import Board
from core.errors import BadInput

PAGES = {"A4": (297.0, 210.0), "A3": (420.0, 297.0), "letter": (279.4, 215.9)}
"""Width and height [mm], lying."""
RIM_MM = 8.0  # [mm] that printers leave blank
TEXT_HEIGHT_MM = 12.0  # [mm] below the board for ruler and words
INCH_MM = 25.4  # [mm]

Page = Literal["A4", "A3", "letter"]
BY_SIZE: tuple[Page, ...] = ("A4", "letter", "A3")


def largest_square(board: Board, page: Page) -> float:
    """[mm]: the side of the largest squares with which such a board fits a page."""
    width, height = PAGES[page]
    return min((width - 2 * RIM_MM) / (board.columns + 1), (height - 2 * RIM_MM - TEXT_HEIGHT_MM) / (board.rows + 1))


def fitting_page(board: Board) -> Page:
    """The smallest page that holds a board; A3 also for boards that are too large for it."""
    for page in BY_SIZE:
        if board.square * 1e3 <= largest_square(board, page):
            return page
    return BY_SIZE[-1]


def board_svg(board: Board, page: Page = "A4") -> str:
    """A board → an SVG page in real size. Raises BadInput with the largest square that fits."""
    width, height = PAGES[page]
    side = board.square * 1e3
    across, down = (board.columns + 1) * side, (board.rows + 1) * side
    largest = largest_square(board, page)
    if side > largest:
        raise BadInput(
            f"A {board.name} board of {side:g} mm squares does not fit {page}; at most {int(largest)} mm do."
        )
    left, top = (width - across) / 2, (height - TEXT_HEIGHT_MM - down) / 2
    squares = [
        f'<rect x="{left + column * side:.3f}" y="{top + row * side:.3f}" width="{side:.3f}" height="{side:.3f}"/>'
        for row in range(board.rows + 1)
        for column in range(board.columns + 1)
        if (row + column) % 2 == 0
    ]
    words = (
        f"Beckon board {board.name} (inner corners), squares {side:g} mm. Print at 100 %, glue it on something stiff "
        f"and flat, measure: 5 squares = {5 * side:g} mm."
    )
    return "\n".join(
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" '
            f'viewBox="0 0 {width:g} {height:g}">',
            f'<rect width="{width:g}" height="{height:g}" fill="white"/>',
            '<g fill="black">',
            *squares,
            "</g>",
            *_ruler(RIM_MM, height - RIM_MM - 6, 100, 1.0, 10, "mm"),
            *_ruler(width - RIM_MM - 4 * INCH_MM, height - RIM_MM - 6, 32, INCH_MM / 8, 8, "inch"),
            f'<text x="{width / 2:g}" y="{height - RIM_MM + 2.5:g}" font-family="sans-serif" font-size="3" '
            f'text-anchor="middle">{words}</text>',
            "</svg>\n",
        )
    )


def _ruler(left: float, top: float, steps: int, step: float, long: int, unit: str) -> list[str]:
    """A ruler of `steps` marks `step` [mm] apart, every `long`-th one longer and numbered."""
    marks = "".join(
        f"M{left + number * step:.3f} {top:g}v{-4 if number % long == 0 else -2}" for number in range(steps + 1)
    )
    numbers = [
        f'<text x="{left + number * step:.3f}" y="{top + 3:g}" font-family="sans-serif" font-size="2.5" '
        f'text-anchor="middle">{number if unit == "mm" else number // long}</text>'
        for number in range(0, steps + 1, long)
    ]
    base = f'<path d="M{left:g} {top:g}h{steps * step:g}{marks}" stroke="black" stroke-width="0.15" fill="none"/>'
    return [
        base,
        *numbers,
        f'<text x="{left:g}" y="{top - 5:g}" font-family="sans-serif" font-size="2.5">{unit}</text>',
    ]
