"""The robot's own microphones: a self-check, and the wizard that finds how the array is turned on the robot."""

from typing import Annotated

from fastapi import Path

from console.access.roles import needs
from console.api import Angle, HistoryInUse, Operator, RequestBody, part, router
from console.calibration.microphones import ArrayCheck, MicrophoneCalibration, MicrophonesState

microphones = router("microphones", 404, 409, 503, 507)
ArrayCalibration = Annotated[MicrophoneCalibration, part(MicrophoneCalibration)]

Number = Annotated[int, Path(ge=0, le=1000)]


class CheckRequest(RequestBody):
    """`show`: a person in the simulated room speaks meanwhile."""

    show: bool = False


class ClapRequest(RequestBody):
    """The direction of a clap, seen from the robot: 0 is ahead, counter-clockwise."""

    azimuth_rad: Angle
    show: bool = False


@microphones.post("/hearing/check", status_code=202)
@needs("operator")
async def check(asked: CheckRequest, array: ArrayCalibration, _: Operator) -> ArrayCheck:
    """Listen for three seconds, in which a person should speak; then ask for the result."""
    array.check(show=asked.show)
    return array.checked()


@microphones.get("/hearing/check")
@needs("viewer")
async def checked(array: ArrayCalibration) -> ArrayCheck:
    """The result of the newest self-check: identical, dead, faint, swapped, clipped channels."""
    return array.checked()


@microphones.get("/calibration/microphones")
@needs("viewer")
async def shown(array: ArrayCalibration) -> MicrophonesState:
    """The state of the microphones' wizard, and the orientation in use."""
    return array.state


@microphones.post("/calibration/microphones/clap", status_code=202)
@needs("operator")
async def clap(asked: ClapRequest, array: ArrayCalibration, _: Operator) -> MicrophonesState:
    """Listen for three seconds to a clap or a word from a known direction; it is `busy` meanwhile."""
    array.clap(asked.azimuth_rad, show=asked.show)
    return array.state


@microphones.post("/calibration/microphones/claps/{number}/drop")
@needs("operator")
async def drop(number: Number, array: ArrayCalibration) -> MicrophonesState:
    """Leave a clap out."""
    array.drop(number)
    return array.state


@microphones.post("/calibration/microphones/again")
@needs("operator")
async def again(array: ArrayCalibration) -> MicrophonesState:
    """Forget all claps and begin again."""
    array.forget()
    return array.state


@microphones.post("/calibration/microphones/accept")
@needs("operator")
async def accept(array: ArrayCalibration, history: HistoryInUse, who: Operator) -> MicrophonesState:
    """Use this orientation from now on."""
    await array.accept(who.name)
    history.add("calibration", who, words="accept microphones")
    return array.state


@microphones.post("/calibration/microphones/undo")
@needs("operator")
async def undo(array: ArrayCalibration, history: HistoryInUse, who: Operator) -> MicrophonesState:
    """The profile's own orientation again."""
    await array.undo()
    history.add("calibration", who, words="undo microphones")
    return array.state
