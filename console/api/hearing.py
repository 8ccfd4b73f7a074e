"""What the robot hears."""

from __future__ import annotations

from typing import Any

from console.api import Behind, Who, Wish, router
from console.problems import Problem
from console.roles import needs

hearing = router("hearing")


class Listening(Wish):
    """Whether the robot listens, and whether it does what voices in the room say; that only its driver may ask."""

    listen: bool
    obey: bool | None = None


@hearing.get("/hearing")
@needs("viewer")
async def newest(behind: Behind) -> dict[str, Any]:
    """The newest utterances near the robot, newest first, and why words are not read, if they are not."""
    told = behind.snapshot.hearing if behind.snapshot is not None else None
    return {
        "microphones": told is not None,
        "listening": told is not None and told.listening,
        "obeying": behind.spoken.driver is not None,
        "trouble": behind.ears.trouble,
        "utterances": behind.ears.shown(),
    }


@hearing.post("/hearing")
@needs("operator")
async def listen(wish: Listening, behind: Behind, who: Who) -> dict[str, Any]:
    """Let the robot listen, or not. It listens by itself for a minute after somebody in the simulated room spoke."""
    if behind.robot.profile.microphones is None:
        raise Problem(404, "This robot has no microphones.")
    if not wish.listen:
        behind.lease.check_not_anothers(who)
    if wish.obey is True and wish.listen:
        behind.spoken.take_on(who)
    elif wish.obey is False or not wish.listen:
        behind.spoken.let_go()
    told = await behind.ask({"do": "listen", "on": wish.listen})
    behind.history.add("listen", who, words="on" if wish.listen else "off")
    return {"listening": bool(told["on"]), "obeying": behind.spoken.driver is not None}
