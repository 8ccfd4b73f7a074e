"""The worker that measures the recognition of voices: minutes of decoding, and killed when given up."""

from __future__ import annotations

from typing import Any

from core.experiments.speech_quality_here import SpeechQualityHere
from core.geometry import Pose
from core.simulation.microphones import MicrophoneSettings
from core.speech.settings import SpeechSettings


class QualityWorker:
    """One run at a time, step by step."""

    def __init__(self) -> None:
        self._run: SpeechQualityHere | None = None

    def begin(self, wish: dict[str, Any], ears: dict[str, Any], speech: dict[str, Any]) -> dict[str, Any]:
        """Prepare a run → the places, and why nobody can speak from some. Raises BadInput, Unavailable."""
        pose = Pose(x=wish["x_m"], y=wish["y_m"], heading=wish["heading_rad"])
        self._run = SpeechQualityHere(
            wish["world"],
            pose,
            wish["towards_rad"],
            wish["distances_m"],
            wish["snr_db"],
            phrases=wish["phrases"],
            ears=MicrophoneSettings(**ears),
            speech=SpeechSettings(**speech),
        )
        places = [
            {"distance_m": one.distance, "snr_db": one.ratio, "refused": one.refused} for one in self._run.places
        ]
        return {"places": places, "voice": self._run.voice}

    def listen_close(self) -> str:
        """Recognize the text as the person's own microphone hears it."""
        assert self._run is not None
        return self._run.listen_close()

    def measure(self, number: int) -> dict[str, Any]:
        """One place → its figures, and the page."""
        assert self._run is not None
        row, report = self._run.measure(self._run.places[number])
        return {"row": row, "page": report}
