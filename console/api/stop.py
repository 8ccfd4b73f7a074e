"""Stop and halt. They act on the headers alone: no body can delay or break them."""

import msgspec

from console.access.roles import needs
from console.api import Dispatcher, NotificationsInUse, RobotInUse, Who, router
from console.control.stop import latched

stop = router("stop", 409, 503, 507)


class Stopped(msgspec.Struct, frozen=True):
    """The robot stands."""

    stopped: bool = True


class Halted(msgspec.Struct, frozen=True, kw_only=True):
    """The robot is halted."""

    halted: bool = True
    latched: bool  # it is on disk
    why: str | msgspec.UnsetType = msgspec.UNSET  # what is wrong where it is not


class ResetHalt(msgspec.Struct, frozen=True):
    """The halt is lifted."""

    halted: bool = False


@stop.post("/stop")
@needs("viewer", reads_body=False)
async def stop_now(dispatcher: Dispatcher, who: Who, press: str = "") -> Stopped:
    """Everything cancelled, zero speed; anyone signed in. Not latched.

    `press`: a number drawn with every press of STOP. The stop always acts; one that comes again with the number of
    the last two seconds, as when a press goes by two ways, is not recorded again.
    """
    dispatcher.stop(who, "rest", number(press))
    return Stopped()


@stop.post("/halt")
@needs("viewer", reads_body=False)
async def halt(
    dispatcher: Dispatcher, robot: RobotInUse, notifications: NotificationsInUse, who: Who, press: str = ""
) -> Halted:
    """A stop that stays until it is reset, over a restart too. `press` as of a stop.

    It answers when the halt is on disk: `latched` true. Where that fails it is false, and `why` says what is wrong.
    """
    dispatcher.halt(who, "rest", number(press))
    why_not = await latched(robot, notifications)
    return Halted(latched=not why_not, why=why_not or msgspec.UNSET)


@stop.post("/halt/reset")
@needs("operator", reads_body=False)
async def reset(dispatcher: Dispatcher, who: Who) -> ResetHalt:
    """Undo the halt; the lease holder only. Never moves."""
    dispatcher.reset(who, "rest")
    return ResetHalt()


def number(press: str) -> int:
    """A press of STOP or Halt; 0 when it has no number, for no number makes a stop fail."""
    return int(press) if press.isascii() and press.isdigit() and len(press) < 17 else 0
