"""Settings of direction finding."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DirectionFindingSettings:
    """Direction of arrival; the values were chosen on simulated rooms other than those of the measurements."""

    frame: float = 0.032  # [s] of one spectrum; a power of two of samples
    steps: int = 4  # spectra per frame length
    lowest: float = 200.0  # [Hz]
    highest: float = 7000.0  # [Hz]
    evidence: float = 5.0  # power over the noise's, after whitening, from which a cell of the spectrogram counts
    reverberation: float = 0.7  # [s] RT60 at which the echo of earlier sound is taken to die away
    precedence: float = 2.0  # how many times the expected echo a cell must exceed to count at all
    whitening: float = 0.7  # 1: phases only (PHAT), 0: plain correlation
    smoothing: int = 5  # bins over which the noise's cross spectra are averaged
    loading: float = 0.02  # share of the noise's power added to its matrix, so that few frames suffice
    quiet_share: float = 0.2  # the share of frames taken for noise when none are given
    grid: int = 1500  # directions that are tried over the whole sphere before refining
    bands: int = 12  # of the spectrum, that vote on how sure the direction is
    spread: float = 1.25  # the bands' disagreement times this is one standard deviation; found by calibration
    echo_sd: float = 0.087  # [rad] for a sound of which nothing comes straight; less as its strength is more
    floor: float = 0.0044  # [rad] no direction is surer than this
    speed_sd: float = 0.01  # of the speed of sound, of itself: 6 °C; a flat array's elevation depends on it
    lean_sd: float = 0.6  # of a flat array's cosine of the elevation, for a sound of which nothing comes straight
    declared_sd: float = 0.26  # [rad] a direction with a larger standard deviation is not declared
    declared_strength: float = 0.25  # nor one whose correlation is weaker, of 1
    glimpse: int = 8  # frames that are looked at together where several may talk at once
    glimpse_strength: float = 0.6  # below it a glimpse holds two voices or an echo, and is not counted
    apart: float = 0.35  # between the unit vectors of two talkers
    share: float = 0.12  # of all glimpses that a further talker must own
    active_share: float = 0.06  # of the bins above the noise, from which a frame holds a voice
    onset_frames: int = 3  # of the last five, that begin an utterance
    hangover: float = 0.5  # [s] of silence that end an utterance
    early: float = 0.35  # [s] of an utterance after which its direction is reported first
    renewal: float = 0.5  # [s] between later directions of the same utterance
    noise_memory: float = 1.0  # [s] over which the noise is averaged
    longest: float = 8.0  # [s] of sound without a pause, after which it is taken for noise
