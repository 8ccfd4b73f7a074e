"""Messages that a browser may send over the socket."""

from typing import Annotated, Literal

import msgspec

Struct = msgspec.Struct
Source = Literal["typed", "chip", "click", "camera"]
PlaybackAction = Literal["play", "pause", "seek", "speed", "way"]
PlaybackWay = Literal["recorded", "computed"]
Short = Annotated[str, msgspec.Meta(max_length=2000)]
Count = Annotated[int, msgspec.Meta(ge=0, le=2**53)]


class InboundMessage(Struct, tag_field="kind", forbid_unknown_fields=True):
    """Base of what a browser may say."""


class JogMessage(InboundMessage, tag="drive"):
    """Hold to drive: sent at 20 Hz while a key or the pad is held. `press` is drawn again with every press."""

    v: float
    w: float
    press: Count
    seq: Count
    nonce: Count
    epoch: Count


class StopMessage(InboundMessage, tag="stop"):
    """Everything cancelled, zero speed. `press` (0: none): its copy over HTTP is recorded once."""

    press: Count = 0


class SayMessage(InboundMessage, tag="command"):
    """Words for the robot. `seen`: `seq` of the newest state that the page has (0: none), which dates them."""

    text: Short
    source: Source
    ref: Count
    seen: Count = 0


class LeaseMessage(InboundMessage, tag="lease"):
    """Take control, take it over, give it back; ask who has it; the answer to who asks: give or keep.

    `leave`: this page is left; control is given back unless the same person has another page open.
    """

    do: Literal["acquire", "take", "release", "leave", "ask", "give", "keep"]
    ref: Count


class HaltMessage(InboundMessage, tag="halt"):
    """Latch a stop. `press` as of `StopMessage`."""

    press: Count = 0


class HaltResetMessage(InboundMessage, tag="halt_reset"):
    """Undo the latch; never moves."""

    ref: Count


class PlaybackMessage(InboundMessage, tag="playback"):
    """Steer a recording: `t_s` [s] from its start is the place to seek, `speed` is in times real time.

    `way` shows what was recorded, or what is computed now; with `compare` one over the other.
    """

    action: PlaybackAction
    ref: Count
    t_s: float | None = None
    speed: float | None = None
    way: PlaybackWay | None = None
    compare: bool = False


class SubscriptionMessage(InboundMessage, tag="want"):
    """Subscriptions of this socket: the camera, and a calibration session (null: none); what is left out stays."""

    camera: bool | msgspec.UnsetType = msgspec.UNSET
    calibration: Annotated[str, msgspec.Meta(max_length=40)] | msgspec.UnsetType | None = msgspec.UNSET


class EchoMessage(InboundMessage, tag="echo"):
    """Comes back as it is: the page measures how long that takes."""

    t: float  # [ms] of the page's clock


Up = (
    JogMessage
    | StopMessage
    | SayMessage
    | LeaseMessage
    | HaltMessage
    | HaltResetMessage
    | PlaybackMessage
    | SubscriptionMessage
    | EchoMessage
)
