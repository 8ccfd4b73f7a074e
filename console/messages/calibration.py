"""A calibration session as the page gets it; the same over REST and over the socket."""

from typing import Any, Literal

import msgspec

Struct = msgspec.Struct
CalibrationKind = Literal["camera", "laser"]
CalibrationSource = Literal["robot", "upload", "webcam"]
Pixel = tuple[float, float]
VerdictKind = Literal[
    "nothing", "refused", "moving", "same", "counted", "background", "gathering", "trouble"
]  # verdicts on a picture or scan


class CalibrationBoard(Struct):
    """The chessboard, counted in inner corners."""

    columns: int
    rows: int
    square_m: float
    panel_m: tuple[float, float] | None = None


class CalibrationVerdict(Struct):
    """The verdict on one picture or scan; `number` counts them."""

    kind: VerdictKind
    words: str
    name: str = ""
    number: int = 0
    corners: list[Pixel] | None = None
    laser: list[tuple[float, float, float, bool]] | None = None  # u, v [pixel], range [m], on the board
    beams: list[int] | None = None
    stamp_s: float | None = None


class CalibrationAdvice(Struct):
    """The next view to take."""

    words: str
    outline: list[Pixel]
    corners: list[Pixel]


class CalibrationBars(Struct):
    """How far the views span place, size and skew, 0..1."""

    x: float
    y: float
    size: float
    skew: float


class CalibrationProgress(Struct):
    """How far the wizard is; the lower keys belong to one kind of session only."""

    views: int
    ready: bool
    words: str
    p95_px: float | None = None
    target_px: float | None = None
    bars: CalibrationBars | None = None
    cells: list[list[int]] | None = None  # 6 rows of 8
    precision: dict[str, float] | None = None  # by direction, 0..1
    weak: list[str] | None = None
    laser_offset: str | None = None
    from_ruler: dict[str, str] | None = None  # direction → "by ruler" or "as level": not known from the poses
    known_from: float | None = None  # gain from which a direction counts as known


class CalibrationView(Struct):
    """A view or a pose in the session."""

    name: str
    dropped: bool
    rms_px: float | None = None
    rms_m: float | None = None
    used: bool | None = None
    reason: str = ""


class CalibrationUncertainty(Struct):
    """Standard deviation of the projection over the picture, row by row."""

    columns: int
    rows: int
    sd_px: list[list[float | None]]


class CalibrationSolving(Struct):
    """A solution is being made."""

    since_s: float
    words: str


class CalibrationCheck(Struct):
    """How the solution predicted a pose that had no part in it."""

    name: str
    off_px: float
    residual_rms_m: float
    beams: int
    words: str


class CalibrationScan(Struct):
    """The laser's newest scan in its own frame [m]; `board` are indices of `points`."""

    points: list[Pixel]
    background: list[Pixel]
    board: list[int]


class CalibrationSessionState(Struct):
    """Everything about one calibration."""

    id: str
    kind: CalibrationKind
    source: CalibrationSource
    board: CalibrationBoard
    created_s: float
    height_m: float | None = None  # laser: of the camera above it, by ruler
    size: tuple[int, int] | None = None
    live: bool = False
    demo: bool = False
    verdict: CalibrationVerdict | None = None
    advice: CalibrationAdvice | None = None
    progress: CalibrationProgress = msgspec.field(
        default_factory=lambda: CalibrationProgress(0, False, "Not begun yet.")
    )
    uncertainty: CalibrationUncertainty | None = None
    views: list[CalibrationView] = msgspec.field(default_factory=list[CalibrationView])
    solving: CalibrationSolving | None = None
    solution: dict[str, Any] | None = None
    check: CalibrationCheck | None = None
    accepted_s: float | None = None
    active_compare: dict[str, tuple[float, float]] | None = None  # by name: now, in use
    scan: CalibrationScan | None = None


class CalibrationNews(Struct, tag_field="kind", tag="calibration"):
    """A session has changed; sent whole, the newest only, at most ten times a second (a counted view at once)."""

    session: CalibrationSessionState
