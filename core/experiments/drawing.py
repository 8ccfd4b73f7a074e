"""One style for all figures, and the way from a drawing to a file; matplotlib is loaded when something is drawn."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal

from core.errors import Unavailable
from core.install import install_extra

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NO_MATPLOTLIB = f"The figures were not drawn: install the extra figures ({install_extra('figures')})."
PIXELS_PER_INCH = 100  # [px/inch]: sizes are given in pixels
TEXT, SOFT, LINE = "#13202c", "#435567", "#d8e0e7"
STYLE: Any = {  # rcParams by their names
    "font.family": ["DejaVu Sans", "sans-serif"],
    "font.size": 9.5,
    "text.color": TEXT,
    "axes.edgecolor": "#7d8fa0",
    "axes.labelcolor": SOFT,
    "axes.titlesize": 11,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": LINE,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "legend.frameon": False,
    "figure.dpi": PIXELS_PER_INCH,
    "figure.constrained_layout.w_pad": 0.12,  # [inch]
    "figure.constrained_layout.h_pad": 0.08,
    "svg.fonttype": "none",  # words stay words, to be searched and read aloud
    "svg.hashsalt": "beckon",  # the same drawing gives the same file
}


def render(
    form: Literal["png", "svg"], size: tuple[int, int], title: str, conditions: str, draw: Callable[[Figure], None]
) -> bytes:
    """Draw on a sheet of `size` [px] with a title above and the conditions below → a file. Raises Unavailable.

    `draw` puts axes and a legend on the sheet; constrained layout gives each its place.
    """
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError:
        raise Unavailable(NO_MATPLOTLIB) from None
    file = io.BytesIO()
    with rc_context(STYLE):
        figure = Figure(figsize=(size[0] / PIXELS_PER_INCH, size[1] / PIXELS_PER_INCH), layout="constrained")
        figure.suptitle(title, fontsize=15, fontweight="bold")
        figure.supxlabel(conditions, fontsize=9.5, color=SOFT)
        draw(figure)
        _lay_out(figure)
        figure.savefig(file, format=form, metadata={"Date": None, "Title": title} if form == "svg" else None)
    return file.getvalue()


def _lay_out(figure: Figure) -> None:
    """Fix every axes' place to a millionth of the sheet: the solver's last digits differ from run to run."""
    if (engine := figure.get_layout_engine()) is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")
    for axes in figure.axes:
        left, bottom, width, height = (round(edge, 6) for edge in axes.get_position(original=True).bounds)
        axes.set_position((left, bottom, width, height))
