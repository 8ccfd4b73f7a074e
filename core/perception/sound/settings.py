"""Settings of direction finding."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from core.errors import BadInput
from core.setting import Meta, Section


@dataclass(frozen=True)
class DirectionFindingSettings(Section):
    """Direction of arrival; the values were chosen on simulated rooms other than those of the measurements."""

    form: Annotated[
        Literal["steered", "paper"], Meta(meaning="steered power less the noise, or eq. 35-40 as they are printed")
    ] = "steered"
    frame: Annotated[float, Meta("s", 0.008, 0.128, "length of a spectrum; nearest power of two of samples")] = 0.032
    steps: Annotated[int, Meta("", 2, 16, "spectra per frame length")] = 4
    lowest: Annotated[float, Meta("Hz", 20, 4000, "lowest frequency that is used")] = 200.0
    highest: Annotated[float, Meta("Hz", 500, 20000, "highest frequency that is used")] = 7000.0
    evidence: Annotated[
        float,
        Meta("", 1, 100, "power over the noise's, after whitening, from which a cell of the spectrogram counts"),
    ] = 5.0
    reverberation: Annotated[
        float, Meta("s", 0.05, 5, "RT60 with which the echo of earlier sound is expected to decay")
    ] = 0.7
    precedence: Annotated[float, Meta("", 0, 20, "factor over the expected echo for a cell to count")] = 2.0
    whitening: Annotated[float, Meta("", 0, 1, "1: phases only (PHAT), 0: plain correlation")] = 0.7
    smoothing: Annotated[int, Meta("bins", 1, 64, "width over which the noise's cross spectra are averaged")] = 5
    loading: Annotated[
        float, Meta("", 1e-6, 1, "share of the noise's power added to its matrix, so that few frames suffice")
    ] = 0.02
    quiet_share: Annotated[float, Meta("", 0.01, 0.9, "share of frames taken for noise when none are given")] = 0.2
    grid: Annotated[int, Meta("", 100, 20000, "directions over the whole sphere tried before refining")] = 1500
    bands: Annotated[int, Meta("", 2, 60, "bands of the spectrum whose agreement gives the sd of a direction")] = 12
    spread: Annotated[float, Meta("", 0.1, 10, "sd per disagreement of the bands; found by calibration")] = 1.25
    echo_sd: Annotated[
        float, Meta("rad", 0, 1, "sd added for a sound without a direct path; less with more strength")
    ] = 0.087
    floor: Annotated[float, Meta("rad", 1e-4, 0.5, "least sd of a direction")] = 0.0044
    speed_sd: Annotated[
        float, Meta("", 0, 0.2, "relative sd of the speed of sound (6 °C); moves a flat array's elevation")
    ] = 0.01
    lean_sd: Annotated[
        float, Meta("", 0, 2, "sd of a flat array's cosine of the elevation, for a sound without a direct path")
    ] = 0.6
    declared_sd: Annotated[float, Meta("rad", 0.01, 3, "sd of a declared direction, at most")] = 0.26
    declared_strength: Annotated[float, Meta("", 0, 1, "correlation of a declared direction, at least")] = 0.25
    declared_misfit: Annotated[
        float, Meta("", 1, 100, "what no plane wave explains of a declared direction, of what is expected, at most")
    ] = 2.5
    glimpse: Annotated[int, Meta("frames", 2, 64, "length analysed together where several may talk at once")] = 8
    glimpse_strength: Annotated[
        float, Meta("", 0, 1, "a weaker glimpse holds two voices or an echo, and is not counted")
    ] = 0.6
    apart: Annotated[float, Meta("", 0.05, 2, "distance between the unit vectors of two talkers, at least")] = 0.35
    share: Annotated[float, Meta("", 0.01, 1, "share of all glimpses that a further talker must own")] = 0.12
    active_share: Annotated[
        float, Meta("", 0.001, 1, "share of the bins above the noise from which a frame holds a voice")
    ] = 0.06
    onset_frames: Annotated[int, Meta("frames", 1, 5, "frames with a voice, of five, that begin an utterance")] = 3
    hangover: Annotated[float, Meta("s", 0.05, 5, "silence that ends an utterance")] = 0.5
    early: Annotated[float, Meta("s", 0.05, 5, "time until an utterance's direction is first reported")] = 0.35
    renewal: Annotated[float, Meta("s", 0.05, 10, "time between later directions of an utterance")] = 0.5
    noise_memory: Annotated[float, Meta("s", 0.05, 30, "time over which the noise is averaged")] = 1.0
    longest: Annotated[float, Meta("s", 1, 60, "sound without a pause is taken for noise after this time")] = 8.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lowest >= self.highest:
            raise BadInput(f"lowest must lie below highest: {self.lowest:g} and {self.highest:g} Hz.")
