"""Listen while sound comes in: noise is learned in silence, directions are reported 0.35 s into an utterance."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from core.message import Array, message
from core.perception.sound.direction import Direction
from core.perception.sound.locate import DEFAULT
from core.perception.sound.multi_source import share_out
from core.perception.sound.paper import FRAME_SAMPLES, direction_as_printed
from core.perception.sound.settings import DirectionFindingSettings
from core.perception.sound.spectra import (
    Noise,
    Spectra,
    cell_weights,
    frame_size,
    framed,
    noise_from,
    noise_of,
    over_noise,
    quiet_frames,
)
from core.perception.sound.voice_activity import VoiceActivityDetector, active_share
from core.sensors.microphones import MicrophoneArray, Sound

SPECTRA_MEMORY_S = 12.0  # of spectra that are remembered
FIRST_NOISE_S = 0.4  # of sound from which the noise is learnt before anything is heard
LEAD_S = 0.3  # before an utterance that are looked at with it
GUARD_S = 0.15  # before now that are not yet taken for noise: an utterance may be beginning
MAX_GAP_S = 0.02  # missing between two pieces of sound, beyond which listening starts again
MOST_TALKERS = 2
MOTORS_MEMORIES = 6  # of the noise, after which the robot's own motors are forgotten
BEFORE_S, AFTER_S = 0.6, 0.1  # before words that show the noise, and after them that are still theirs
MIN_TALKED_STRENGTH, TALKED_SHARE = 0.5, 0.25  # of who talked before words, and what of it is left in them, at least
MAX_TALKER_RAD = 0.6  # from a talker, within which a direction is theirs at most
MOST_IN_WORDS = 3  # directions of words: the talker's, an echo's, another talker's


def _less_where(one: Direction, talked: Sequence[Direction]) -> Direction:
    """A direction in words, with less strength where someone talked from there before them."""
    near = any(
        one.angle_to(other.towards) < min(3 * math.hypot(one.azimuth_sd, other.azimuth_sd), MAX_TALKER_RAD)
        for other in talked
    )
    return replace(one, strength=TALKED_SHARE * one.strength) if near else one


@message
class HeardDirections:
    """Directions of an utterance: reported early, renewed while it lasts, and once more at its end."""

    begin: float  # [s]
    end: float | None  # [s]; None while it lasts
    directions: tuple[Direction, ...]  # strongest first


class DoaStream:
    """Estimates the directions of utterances in a stream of sound."""

    def __init__(self, array: MicrophoneArray, settings: DirectionFindingSettings = DEFAULT) -> None:
        self.array, self.settings = array, settings
        self._forget(0.0)

    def _forget(self, now: float) -> None:
        self._pending = np.zeros((0, len(self.array.positions)))
        self._start = now  # [s] of the first pending sample
        self._pieces: deque[Spectra] = deque()
        self._latest = np.zeros((0, len(self.array.positions)))  # samples of the paper's form, until …
        self._until = now  # [s]
        self._cross: Array | None = None
        self._noise: Noise | None = None
        self._learnt = now
        self._reported = now
        self._moved = -math.inf  # [s] when the robot last moved
        self._activity = VoiceActivityDetector(self.settings)
        self._rate = 0

    @property
    def speaking(self) -> bool:
        """True while an utterance is under way."""
        return self._activity.begin is not None

    def feed(self, sound: Sound, *, moving: bool = False) -> tuple[HeardDirections, ...]:
        """The next piece of sound → what became known with it. A gap in time resets the state. Raises BadInput.

        `moving`: the robot moved while it sounded, so that its motors are in the noise.
        """
        samples = self.array.heard(sound)
        expected = self._start + len(self._pending) / (self._rate or sound.rate)
        if sound.rate != self._rate or abs(sound.stamp - expected) > MAX_GAP_S:
            self._forget(sound.stamp)
            self._rate = sound.rate
        if moving:
            self._moved = sound.stamp + sound.duration
        self._pending = np.concatenate((self._pending, samples))
        if self.settings.form == "paper":
            self._latest = np.concatenate((self._latest, samples))[-round(SPECTRA_MEMORY_S * sound.rate) :]
            self._until = sound.stamp + sound.duration
        size = frame_size(sound.rate, self.settings)
        if len(self._pending) < size:
            return ()
        seen = framed(self._pending, sound.rate, self.settings)
        seen = replace(seen, times=seen.times + self._start)
        used = len(seen.times) * (size // self.settings.steps)
        self._pending, self._start = self._pending[used:], self._start + used / sound.rate
        self._pieces.append(seen)
        while self._pieces[0].times[-1] < seen.times[-1] - SPECTRA_MEMORY_S:
            self._pieces.popleft()
        return self._judge(seen)

    def within(self, begin: float, end: float) -> tuple[HeardDirections, ...]:
        """Look once more at words that were spoken from `begin` to `end` [s]: at all of them, and at either half.

        Who spoke just before is noise to them and weighs less; who spoke into them is not in both halves. () where so
        much of the sound is not remembered, or in the paper's form.
        """
        pieces = self._pieces
        if not pieces or self.settings.form == "paper" or pieces[0].times[0] > begin - LEAD_S:
            return ()
        seen = self._since(begin - BEFORE_S)
        quiet = (seen.times >= begin - BEFORE_S) & (seen.times + seen.size / (2 * seen.rate) <= begin)
        if not quiet.any():
            return ()
        noise = self._with_motors(noise_of(seen, quiet, self.settings), end)
        fresh = cell_weights(over_noise(seen, noise), seen, self.settings)
        talked = self._heard_before(seen, quiet)
        middle = (begin + end) / 2
        heard: list[HeardDirections] = []
        for first, last in ((begin, end), (begin, middle), (middle, end)):
            until = last + AFTER_S if last == end else last
            own = np.where((seen.times >= first) & (seen.times <= until), fresh, 0.0)
            found = share_out(seen, own, noise, self.array, 0.0, self.settings, MOST_IN_WORDS)
            weighed = tuple(_less_where(one, talked) for one in found)
            heard.append(HeardDirections(begin=first, end=last, directions=weighed))
        return tuple(heard)

    def _heard_before(self, seen: Spectra, frames: Array) -> tuple[Direction, ...]:
        """Directions of voices in these frames (T,) bool before words."""
        if self._noise is None:
            return ()
        fresh = cell_weights(over_noise(seen, self._noise), seen, self.settings) * frames
        found = share_out(seen, fresh, self._noise, self.array, 0.0, self.settings, MOST_IN_WORDS)
        return tuple(one for one in found if one.strength > MIN_TALKED_STRENGTH)

    def _judge(self, seen: Spectra) -> tuple[HeardDirections, ...]:
        """Frames that are new → what became known."""
        now = float(seen.times[-1])
        if self._noise is None:
            if now - self._pieces[0].times[0] < FIRST_NOISE_S:
                return ()
            past = self._since(0.0)
            self._learn(noise_of(past, quiet_frames(past, self.settings), self.settings), now)
        assert self._noise is not None
        heard: list[HeardDirections] = []
        begin = self._activity.begin
        for time, share in zip(seen.times, active_share(over_noise(seen, self._noise), self.settings), strict=True):
            change = self._activity.step(float(share), float(time))
            if change == "begins":
                begin = self._activity.begin
                self._reported = (begin or 0.0) + self.settings.early - self.settings.renewal
            elif change == "ends" and begin is not None:
                heard.append(self._report(begin, begin, self._activity.last_active))
        begin = self._activity.begin
        if begin is None:
            self._attend(now)
        elif now - begin > self.settings.longest:
            past = self._since(begin)
            self._activity = VoiceActivityDetector(self.settings)
            self._learn(noise_of(past, quiet_frames(past, self.settings), self.settings), now)
        elif now - self._reported >= self.settings.renewal:
            heard.append(self._report(begin, max(begin, now - 2 * self.settings.renewal), None))
            self._reported = now
        return tuple(heard)

    def _attend(self, now: float) -> None:
        """Silence: what was heard a moment ago is noise."""
        assert self._cross is not None
        step = self._pieces[-1].size / self.settings.steps / self._rate
        weight = step / self.settings.noise_memory
        past = self._since(self._learnt - GUARD_S)
        settled = (past.times > self._learnt - GUARD_S) & (past.times <= now - GUARD_S)
        if now - self._learnt < GUARD_S or not settled.any():
            return
        values = past.values[:, :, settled]
        share = 1 - (1 - weight) ** int(settled.sum())
        mean = values @ values.conj().swapaxes(1, 2) / settled.sum()
        self._cross = (1 - share) * self._cross + share * mean
        self._noise, self._learnt = self._with_motors(noise_from(self._cross, self.settings), now), now

    def _learn(self, noise: Noise, now: float) -> None:
        self._noise, self._cross, self._learnt = self._with_motors(noise, now), noise.cross, now

    def _with_motors(self, noise: Noise, now: float) -> Noise:
        return replace(noise, has_motors=now - self._moved < MOTORS_MEMORIES * self.settings.noise_memory)

    def _report(self, begin: float, since: float, end: float | None) -> HeardDirections:
        """Look at the sound from `since` [s] on."""
        assert self._noise is not None
        if self.settings.form == "paper":
            return HeardDirections(begin=begin, end=end, directions=self._as_printed(since, end))
        seen = self._since(since - LEAD_S)
        fresh = cell_weights(over_noise(seen, self._noise), seen, self.settings)
        fresh = np.where(seen.times >= since - LEAD_S / 3, fresh, 0.0)
        directions = share_out(seen, fresh, self._noise, self.array, 0.0, self.settings, MOST_TALKERS)
        self._learnt = float(seen.times[-1])
        return HeardDirections(begin=begin, end=end, directions=directions)

    def _as_printed(self, since: float, end: float | None) -> tuple[Direction, ...]:
        """The paper's one direction of the sound from `since` to `end` [s]; none of less than one of its frames."""
        self._learnt = self._until
        last = self._until if end is None else min(end, self._until)
        first, stop = (round((time - self._until) * self._rate) + len(self._latest) for time in (since, last))
        part = self._latest[max(first, 0) : max(stop, 0)]
        if len(part) < FRAME_SAMPLES:
            return ()
        return (direction_as_printed(part, self._rate, (since + last) / 2, self.array),)

    def _since(self, time: float) -> Spectra:
        """All remembered spectra from about `time` [s] on."""
        pieces = [piece for piece in self._pieces if piece.times[-1] >= time] or [self._pieces[-1]]
        return replace(
            pieces[-1],
            values=np.concatenate([piece.values for piece in pieces], axis=2),
            times=np.concatenate([piece.times for piece in pieces]),
        )
