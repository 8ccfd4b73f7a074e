"""Settings of direction finding."""

from dataclasses import dataclass
from typing import Annotated, Literal

from core.errors import BadInput
from core.setting import Meta, Section


@dataclass(frozen=True)
class DirectionFindingSettings(Section):
    """Direction of arrival; the values were chosen on simulated rooms other than those of the measurements.

    Watch:
        form: error of the directions in `beckon experiment direction-of-arrival`
        lowest: directions beside a fan; raise it for wrong ones
        highest: directions of high voices; lower it where those of a wide array jump
        reverberation: directions in a hall; raise it for those of echoes
        declared_sd: directions that are drawn; lower it for uncertain ones
        declared_strength: directions that are drawn without anybody speaking (then raise it)
        hangover: sentences with two directions (then raise it)
    """

    frame: float = 0.032  # [s] length of a spectrum; nearest power of two of samples
    steps: int = 4  # spectra per frame length
    evidence: float = 5.0  # power over the noise's, after whitening, from which a cell of the spectrogram counts
    precedence: float = 2.0  # factor over the expected echo for a cell to count
    whitening: float = 0.7  # 1: phases only (PHAT), 0: plain correlation
    smoothing: int = 5  # [bins] width over which the noise's cross spectra are averaged
    loading: float = 0.02  # share of the noise's power added to its matrix, so that few frames suffice
    quiet_share: float = 0.2  # share of frames taken for noise when none are given
    grid: int = 1500  # directions over the whole sphere tried before refining
    bands: int = 12  # bands of the spectrum whose agreement gives the sd of a direction
    spread: float = 1.25  # sd per disagreement of the bands; found by calibration
    echo_sd: float = 0.087  # [rad] sd added for a sound without a direct path; less with more strength
    floor: float = 0.0044  # [rad] least sd of a direction
    speed_sd: float = 0.01  # relative sd of the speed of sound (6 °C); moves a flat array's elevation
    lean_sd: float = 0.6  # sd of a flat array's cosine of the elevation, for a sound without a direct path
    declared_misfit: float = 2.5  # what no plane wave explains of a declared direction, of what is expected, at most
    glimpse: int = 8  # [frames] length analysed together where several may talk at once
    glimpse_strength: float = 0.6  # a weaker glimpse holds two voices or an echo, and is not counted
    apart: float = 0.35  # distance between the unit vectors of two talkers, at least
    share: float = 0.12  # share of all glimpses that a further talker must own
    active_share: float = 0.06  # share of the bins above the noise from which a frame holds a voice
    onset_frames: int = 3  # [frames] frames with a voice, of five, that begin an utterance
    early: float = 0.35  # [s] time until an utterance's direction is first reported
    renewal: float = 0.5  # [s] time between later directions of an utterance
    noise_memory: float = 1.0  # [s] time over which the noise is averaged
    longest: float = 8.0  # [s] sound without a pause is taken for noise after this time
    form: Annotated[
        Literal["steered", "paper"], Meta(meaning="steered power less the noise, or eq. 35-40 as they are printed")
    ] = "steered"
    lowest: Annotated[float, Meta("Hz", 20, 4000, "lowest frequency that is used")] = 200.0
    highest: Annotated[float, Meta("Hz", 500, 20000, "highest frequency that is used")] = 7000.0
    reverberation: Annotated[
        float, Meta("s", 0.05, 5, "RT60 with which the echo of earlier sound is expected to decay")
    ] = 0.7
    declared_sd: Annotated[float, Meta("rad", 0.01, 3, "sd of a declared direction, at most")] = 0.26
    declared_strength: Annotated[float, Meta("", 0, 1, "correlation of a declared direction, at least")] = 0.25
    hangover: Annotated[float, Meta("s", 0.05, 5, "silence that ends an utterance")] = 0.5

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lowest >= self.highest:
            raise BadInput(f"lowest must lie below highest: {self.lowest:g} and {self.highest:g} Hz.")
