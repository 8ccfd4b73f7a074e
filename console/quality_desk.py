"""The worker that measures how well somebody is understood here: minutes of decoding, and killed when given up."""

from __future__ import annotations

from typing import Any

from core.experiments.heard_here import HeardHere
from core.geometry import Pose
from core.sensors.simulated_microphones import EarSettings
from core.speech.settings import SpeechSettings


class QualityDesk:
    """One run at a time, step by step."""

    def __init__(self) -> None:
        self._run: HeardHere | None = None

    def begin(self, wish: dict[str, Any], ears: dict[str, Any], speech: dict[str, Any]) -> dict[str, Any]:
        """What is wanted → the places, and why nobody can speak from some. Raises BadInput, Unavailable."""
        pose = Pose(x=wish["x_m"], y=wish["y_m"], heading=wish["heading_rad"])
        self._run = HeardHere(
            wish["world"],
            pose,
            wish["towards_rad"],
            wish["distances_m"],
            wish["snr_db"],
            phrases=wish["phrases"],
            ears=EarSettings(**ears),
            speech=SpeechSettings(**speech),
        )
        places = [
            {"distance_m": one.distance, "snr_db": one.ratio, "refused": one.refused} for one in self._run.places
        ]
        return {"places": places, "voice": self._run.voice}

    def listen_close(self) -> str:
        """What the person's own microphone makes of the text."""
        assert self._run is not None
        return self._run.listen_close()

    def measure(self, number: int) -> dict[str, Any]:
        """One place → its figures, and the page."""
        assert self._run is not None
        row, report = self._run.measure(self._run.places[number])
        return {"row": row, "page": report}
