"""Find utterances in a stream of sound; each one keeps the half second before it.

An utterance is over when what follows is much fainter than its loudest moment, be it other people's talk.
A frame holds a voice where clearly more bins of its spectrum stand out of the noise than the noise itself lifts
there; the noise, and how unquiet it is, are learnt in silence, and from what sets in and then stays as loud as it is:
a motor, a fan. Nobody speaks as steadily.
"""

from collections import deque

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from core.message import Array
from core.sensors.microphones import Sound
from core.speech.recognition.recognizer import Utterance, checked
from core.speech.settings import RATE_HZ, SpeechSettings

FRAME_SAMPLES = 512  # samples of a frame
HOP_SAMPLES = 128  # between frames: 8 ms
BAND = slice(6, 160)  # bins from 190 to 5000 Hz
STEP = HOP_SAMPLES / RATE_HZ  # [s]
FIRST_SOUND_S = 0.4  # of sound after which something can be heard at all
LIVELY_RATIO = 10.0  # times the quietest frames' power, that the mean has during speech
MAX_GAP_S = 0.02  # missing between two pieces of sound, beyond which listening starts again
SILENT_POWER = 1e-7  # power of a bin that counts as silence whatever the noise: about -75 dB of full scale
QUIET_SHARE = 0.3  # of the frames, that are taken for noise where nothing is known of it
SMOOTHING_BINS = 15  # bins over which that noise is averaged
BLOCK_FRAMES = 6  # frames of which one loudness is computed: 48 ms
STEADY = 31 * BLOCK_FRAMES  # frames: 1.5 s
MAX_LEVEL_SD_DB = 1.5  # standard deviation of a noise's loudness in that time: motors 0.2 to 1.1, voices 2.3 up
MAX_RISE_DB = 4.5  # above its mean that such a noise reaches; what was louder before was a voice
WITHIN_DB, ABOVE_DB = 16.0, 6.0  # below the loudest and above the quietest frames, between which a voice begins
MIN_VOICED_FRAMES = 12  # frames with a voice, that make an utterance
SHORT_UTTERANCE_S = 1.2  # of an utterance that is soon read


class Endpointer:
    """Cuts sound into utterances."""

    def __init__(self, settings: SpeechSettings | None = None) -> None:
        self._settings = settings or SpeechSettings()
        self.hangover = self._settings.hangover  # [s] that ends the utterance; who reads `so_far` may know better
        self._forget(0.0)

    def _forget(self, now: float) -> None:
        self._samples = np.zeros(0)  # all that is remembered
        self._start = now  # [s] of the first of them
        self._framed = 0  # of them, where the next frame begins
        self._first: list[Array] = []  # spectra from which the noise is learnt before anything is heard
        self._noise: Array | None = None  # (K,) power
        self._unquiet = self._unrest = 0.0  # share of bins that the noise itself lifts, and its variance
        self._recent: deque[tuple[float, bool]] = deque(maxlen=6)
        self._levels: deque[float] = deque(maxlen=STEADY)  # [dB] of the utterance under way
        self._begin: float | None = None
        self._last_voice = now
        self._loudest = 0.0  # [dB] of the utterance under way

    @property
    def speaking_since(self) -> float | None:
        """First voiced moment [s] of the utterance under way; None: there is none."""
        return self._begin

    def feed(self, sound: Sound) -> tuple[Utterance, ...]:
        """The next piece of sound → utterances that ended in it. A gap in time resets the state. Raises BadInput."""
        samples = checked(sound)
        if abs(sound.stamp - self._now) > MAX_GAP_S:
            self._forget(sound.stamp)
        self._samples = np.concatenate((self._samples, samples))
        count = (len(self._samples) - self._framed - FRAME_SAMPLES) // HOP_SAMPLES + 1
        if count <= 0:
            return ()
        fresh = self._samples[self._framed : self._framed + FRAME_SAMPLES + (count - 1) * HOP_SAMPLES]
        power = _powers(fresh)  # (T, K)
        times = self._start + (self._framed + FRAME_SAMPLES / 2 + HOP_SAMPLES * np.arange(count)) / RATE_HZ
        self._framed += count * HOP_SAMPLES
        ended = [one for row, time in zip(power, times, strict=True) if (one := self._step(row, float(time)))]
        self._drop_old()
        return tuple(ended)

    @property
    def so_far(self) -> Utterance | None:
        """The utterance under way, when its speaker has just made a short pause: it may be over."""
        framed_until = self._start + (self._framed + FRAME_SAMPLES / 2) / RATE_HZ
        if self._begin is None or framed_until - self._last_voice < self._pause(self._begin):
            return None
        return self._utterance(self._begin, False)

    def _pause(self, begin: float) -> float:
        """The silence [s] after which the utterance since `begin` [s] is read."""
        short = self._last_voice - begin <= SHORT_UTTERANCE_S
        return self._settings.pause if short else self._settings.long_pause

    @property
    def under_way(self) -> Utterance | None:
        """The utterance under way, as far as it goes."""
        return None if self._begin is None else self._utterance(self._begin, False)

    def finish(self) -> tuple[Utterance, ...]:
        """The sound is over → the utterance that was under way."""
        last = self._cut(False) if self._begin is not None else None
        self._forget(self._now)
        return (last,) if last else ()

    @property
    def _now(self) -> float:
        return self._start + len(self._samples) / RATE_HZ

    def _step(self, power: Array, time: float) -> Utterance | None:
        """One frame (K,) at `time` [s] → the utterance that it ends."""
        settings = self._settings
        if self._noise is None:
            self._first.append(power)
            if len(self._first) * STEP >= FIRST_SOUND_S:
                self._learn(np.array(self._first))
            return None
        share = float(np.mean(power > settings.evidence * self._noise))
        voice = share > max(settings.voice_share, self._unquiet + settings.voice_margin * self._unrest**0.5)
        self._recent.append((time, voice))
        level = 10 * float(np.log10(power.mean() + SILENT_POWER))
        self._loudest = max(self._loudest, level) if self._begin is not None else level
        if voice and level > self._loudest - settings.dynamics:
            self._last_voice, self.hangover = time, settings.hangover
        if self._begin is None:
            self._attend(power, share, voice)
            voices = [when for when, was in self._recent if was]
            if len(voices) >= settings.onset:
                self._begin = voices[0]
                self._levels.clear()
            return None
        self._levels.append(level)
        if len(self._levels) == STEADY and _is_steady(np.array(self._levels)):
            return self._cut_before_noise(time)
        if time - self._last_voice > self.hangover:
            return self._cut(False)
        if time - self._begin > settings.longest:
            utterance = self._cut(True)
            self._learn(_powers(self._samples))
            return utterance
        return None

    def _cut_before_noise(self, time: float) -> Utterance | None:
        """End the utterance before the steady noise, heard until `time` [s], which counts as silence from now on."""
        voice = self._loudest > np.mean(self._levels) + MAX_RISE_DB
        self._last_voice = time - STEADY * STEP
        utterance = self._cut(False)
        end = round((time - self._start) * RATE_HZ) + FRAME_SAMPLES // 2
        self._learn(_powers(self._samples[end - STEADY * HOP_SAMPLES : end]))
        return utterance if voice else None

    def _learn(self, power: Array) -> None:
        """Frames (T, K) of what is there now: all of them are noise, unless a person already speaks among them."""
        quiet, mean = quietest(power), _smoothed(power.mean(0))
        speech = mean.mean() > LIVELY_RATIO * quiet.mean()
        self._noise = np.maximum(quiet if speech else mean, SILENT_POWER)
        shares = np.mean(power > self._settings.evidence * self._noise, axis=1)
        self._unquiet = 0.0 if speech else float(shares.mean())
        self._unrest = 0.0 if speech else float(shares.var())

    def _attend(self, power: Array, share: float, voice: bool) -> None:
        """Silence, as far as is known: the noise follows what is heard; slowly where it may be a voice."""
        assert self._noise is not None
        weight = STEP / self._settings.noise_memory * (0.1 if voice else 1.0)
        self._noise = np.maximum(self._noise + weight * (power - self._noise), SILENT_POWER)
        self._unquiet += weight * (share - self._unquiet)
        self._unrest += weight * ((share - self._unquiet) ** 2 - self._unrest)

    def _cut(self, too_long: bool) -> Utterance | None:
        """The utterance under way, ended; None for a click."""
        assert self._begin is not None
        utterance = self._utterance(self._begin, too_long)
        self._begin = None
        self._recent.clear()
        return utterance

    def _utterance(self, begin: float, too_long: bool) -> Utterance | None:
        """The sound since `begin` [s]; None for a click."""
        if self._last_voice - begin < self._settings.shortest:
            return None
        whole = Sound(stamp=self._start, rate=RATE_HZ, samples=self._samples[:, None])
        return Utterance(
            sound=whole.part(begin - self._settings.pre_roll, self._now),
            begin=begin,
            end=self._last_voice,
            cut=too_long,
        )

    def _drop_old(self) -> None:
        """Forget what no utterance can reach back to."""
        since = self._begin if self._begin is not None else self._now
        old = round((since - self._settings.pre_roll - 2 * FRAME_SAMPLES / RATE_HZ - self._start) * RATE_HZ)
        if old > RATE_HZ // 4:
            old = min(old, self._framed)
            self._samples = self._samples[old:]
            self._start += old / RATE_HZ
            self._framed -= old


def _powers(samples: Array) -> Array:
    """Samples (N,) → power of the band (T, K)."""
    window = np.sin(np.pi * (np.arange(FRAME_SAMPLES) + 0.5) / FRAME_SAMPLES) ** 2
    frames = sliding_window_view(samples, FRAME_SAMPLES)[::HOP_SAMPLES]
    return np.abs(np.fft.rfft(frames * window)[:, BAND]) ** 2 / (window @ window)


def _is_steady(level: Array) -> bool:
    """Levels [dB] of STEADY frames → whether they are those of a noise, which no voice is part of."""
    return float(level.reshape(-1, BLOCK_FRAMES).mean(axis=1).std()) < MAX_LEVEL_SD_DB


def quietest(power: Array) -> Array:
    """Frames (T, K) → power of the noise (K,): of the quietest frames, averaged over neighbouring bins too."""
    level = np.log(power + SILENT_POWER).mean(1)
    mean = power[level <= np.quantile(level, QUIET_SHARE)].mean(0)
    return np.maximum(_smoothed(mean), SILENT_POWER)


def _smoothed(power: Array) -> Array:
    """(K,) averaged over neighbouring bins."""
    wide = np.pad(power, SMOOTHING_BINS // 2, mode="edge")
    return np.convolve(wide, np.full(SMOOTHING_BINS, 1 / SMOOTHING_BINS), mode="valid")


class Held:
    """Hold-to-talk: all sound until the button is let go is one utterance."""

    def __init__(self, settings: SpeechSettings | None = None) -> None:
        self._settings = settings or SpeechSettings()
        self._pieces: list[Sound] = []

    @property
    def speaking_since(self) -> float | None:
        """First moment [s] of sound since the button was pressed; None while it is not pressed."""
        return self._pieces[0].stamp if self._pieces else None

    @property
    def so_far(self) -> Utterance | None:
        """Nothing: only the button ends the utterance."""
        return None

    @property
    def under_way(self) -> Utterance | None:
        """The utterance under way, as far as it goes."""
        return next(iter(self._utterance(False)), None) if self._pieces else None

    def feed(self, sound: Sound) -> tuple[Utterance, ...]:
        """The next piece of sound. An utterance that is too long is cut and returned at once. Raises BadInput."""
        checked(sound)
        self._pieces.append(sound)
        if sum(piece.duration for piece in self._pieces) > self._settings.longest + 2 * self._settings.pre_roll:
            return self._take(True)
        return ()

    def finish(self) -> tuple[Utterance, ...]:
        """The button was let go."""
        return self._take(False) if self._pieces else ()

    def _take(self, cut: bool) -> tuple[Utterance, ...]:
        taken = self._utterance(cut)
        self._pieces = []
        return taken

    def _utterance(self, cut: bool) -> tuple[Utterance, ...]:
        samples = np.concatenate([piece.samples for piece in self._pieces])
        whole = Sound(stamp=self._pieces[0].stamp, rate=RATE_HZ, samples=samples)
        begin, end = voiced(samples[:, 0])
        if begin >= end:
            return ()
        return (Utterance(sound=whole, begin=whole.stamp + begin, end=whole.stamp + end, cut=cut),)


def voiced(samples: Array, within_db: float = WITHIN_DB) -> tuple[float, float]:
    """Samples (N,) of one utterance → first and last moment [s] with a voice; (0, 0) for none.

    `within_db`: how much fainter than its loudest parts a voice may be.
    """
    if len(samples) < FRAME_SAMPLES:
        return 0.0, 0.0
    level = levels(samples)
    least = max(float(np.quantile(level, 0.95)) - within_db, float(np.quantile(level, QUIET_SHARE)) + ABOVE_DB)
    voices = np.flatnonzero(level > least)
    if len(voices) < MIN_VOICED_FRAMES:
        return 0.0, 0.0
    begin, end = (FRAME_SAMPLES / 2 + HOP_SAMPLES * voices[[0, -1]]) / RATE_HZ
    return float(begin), float(end)


def over_noise(voice: Array, noise: Array) -> float:
    """Samples (N,) with a voice and (M,) without → power of its loud moments over the noise's; ∞ without noise."""
    power = float(np.mean(noise**2)) if len(noise) else 0.0
    return float(np.quantile(np.abs(voice), 0.95)) ** 2 / 2 / power if power > 0.0 else np.inf


def levels(samples: Array) -> Array:
    """Samples (N,) → level [dB] of frames that begin every HOP samples, (T,)."""
    return 10 * np.log10(_powers(samples).mean(1) + SILENT_POWER)
