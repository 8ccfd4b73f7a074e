"""The worker that measures the recognition of voices: minutes of decoding, and killed when given up."""

from console.speech.quality_jobs import BeginQuality, BegunQuality, ListenClose, MeasuredQuality, MeasureQuality
from core.experiments.speech_quality_here import SpeechQualityHere
from core.geometry import Pose


class QualityWorker:
    def __init__(self) -> None:
        self._run: SpeechQualityHere | None = None

    def begin(self, job: BeginQuality) -> BegunQuality:
        """Prepare a run → the places, and why nobody can speak from some."""
        setup = job.setup
        self._run = SpeechQualityHere(
            setup.world,
            Pose(x=setup.x_m, y=setup.y_m, heading=setup.heading_rad),
            setup.towards_rad,
            setup.distances_m,
            setup.snr_db,
            phrases=setup.phrases,
            ears=job.ears,
            speech=job.speech,
        )
        return BegunQuality([one.row for one in self._run.places], self._run.voice)

    def listen_close(self, _: ListenClose) -> str:
        """Recognize the text as the person's own microphone hears it."""
        assert self._run is not None
        return self._run.listen_close()

    def measure(self, job: MeasureQuality) -> MeasuredQuality:
        assert self._run is not None
        return MeasuredQuality(*self._run.measure(self._run.places[job.number]))
