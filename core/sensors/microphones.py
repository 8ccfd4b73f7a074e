"""Microphones: what they heard, and where they sit."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.files import text_of
from core.geometry import Pose
from core.message import Array, message
from core.sensors.checks import are_finite

MAX_PROFILE_BYTES = 100_000  # bytes of an array profile
KEYS = ("name", "positions_m", "channels", "sample_rate_hz", "speed_of_sound_m_s", "position_sd_m")
MIN_MICROPHONES, MAX_MICROPHONES = 2, 256  # microphones
MAX_RATE_HZ = 1_000_000  # of samples
MAX_COORDINATE_M = 5.0  # of a microphone from the frame's origin
MAX_APERTURE_M = 3.0  # between two microphones of one robot
MIN_APERTURE_M = 0.005  # between the farthest two microphones of a profile
MIN_APART_M = 0.0005  # between two microphones of a profile
MAX_SAMPLE = 1e6  # times full scale: files of floats in whole-number units have 3e4; the square of more says nothing
MAX_NUMBER = 1e300  # beyond, a number of a profile counts as not finite
FLAT_SHARE = 0.02  # thickness of the array, of its width, below which it is held to be flat

NO_NUMBERS = (
    "The sound holds samples that are no numbers, or far beyond full scale; the microphone's driver is at fault."
)


@message
class Sound:
    """Samples of all channels over some time."""

    stamp: float  # [s] of the first sample
    rate: int  # [Hz]
    samples: Array  # (N, C), full scale ±1

    def __post_init__(self) -> None:
        if self.samples.ndim != 2 or not self.samples.shape[1]:
            raise BadInput("A sound needs samples of shape (number, channels).")
        if self.rate <= 0 or not math.isfinite(self.stamp):
            raise BadInput("A sound needs a positive sample rate and a finite time.")

    @property
    def malformation(self) -> str:
        """Describe what is wrong with the form of this sound, beyond what no sound can be made of; "": nothing."""
        if self.samples.dtype.kind not in "fiu":
            return "its samples are no numbers"
        if not are_finite(self.stamp, self.rate) or self.rate > MAX_RATE_HZ:
            return "its rate or its time cannot be"
        return "" if self.channels <= MAX_MICROPHONES else f"it has {self.channels} channels"

    @property
    def duration(self) -> float:
        """[s]."""
        return len(self.samples) / self.rate

    @property
    def newest(self) -> float:
        """When its last sample was taken [s]."""
        return self.stamp + self.duration

    @property
    def channels(self) -> int:
        """The number of channels."""
        return self.samples.shape[1]

    def part(self, begin: float, end: float) -> Sound:
        """The sound between two times [s] of its own clock, as far as it reaches."""
        first = min(max(round((begin - self.stamp) * self.rate), 0), len(self.samples))
        last = min(max(round((end - self.stamp) * self.rate), first), len(self.samples))
        return Sound(stamp=self.stamp + first / self.rate, rate=self.rate, samples=self.samples[first:last])

    def pieces(self, longest: float) -> Iterator[Sound]:
        """The sound in pieces of `longest` [s], the last as long as is left; none of them is empty."""
        size = max(round(longest * self.rate), 1)
        for first in range(0, len(self.samples), size):
            stamp = self.stamp + first / self.rate
            yield Sound(stamp=stamp, rate=self.rate, samples=self.samples[first : first + size])


def usable(samples: Array) -> bool:
    """Return whether samples of any shape are all numbers, and none is absurdly far beyond full scale."""
    return bool(np.abs(samples).max(initial=0.0) <= MAX_SAMPLE)


def joined(older: Sound | None, newer: Sound | None, longest: float) -> Sound | None:
    """Two pieces that follow each other → one, of which the newest `longest` [s] are kept; after a gap, the newer."""
    if older is None or newer is None:
        return newer or older
    gap = newer.stamp - older.stamp - older.duration
    if older.rate != newer.rate or older.channels != newer.channels or abs(gap) > 0.5 / newer.rate:
        return newer
    whole = Sound(stamp=older.stamp, rate=older.rate, samples=np.concatenate((older.samples, newer.samples)))
    end = newer.stamp + newer.duration
    return whole.part(end - longest, end)


@message
class MicrophoneArray:
    """Microphones in the array frame: x forward, y left, z up; azimuth counter-clockwise from +x."""

    positions: Array  # (M, 3) [m] in the array frame
    channels: tuple[int, ...] = ()  # which channel of the sound each microphone is; none given: in order
    name: str = "microphones"
    rate: int | None = None  # [Hz] that the board delivers; None: any
    speed: float = 343.0  # [m/s] of sound
    position_sd: float = 0.0005  # [m] how well the positions are known, per axis
    mounting: Pose = Pose()  # robot_from_microphones
    height: float = 0.25  # [m] above the floor

    def __post_init__(self) -> None:
        shape = self.positions.shape
        if len(shape) != 2 or shape[1] != 3 or not MIN_MICROPHONES <= shape[0] <= MAX_MICROPHONES:
            raise BadInput(
                f"positions_m needs {MIN_MICROPHONES} to {MAX_MICROPHONES} rows of three numbers [x, y, z] in metres."
            )
        if not np.isfinite(self.positions).all() or np.abs(self.positions).max() > MAX_COORDINATE_M:
            raise BadInput(
                f"Microphone positions must be finite and within {MAX_COORDINATE_M:g} m; are they in metres?"
            )
        if (apart := float(np.linalg.norm(self.baselines, axis=1).max())) > MAX_APERTURE_M:
            raise BadInput(
                f"Two microphones lie {apart:.3g} m apart, as on no robot ({MAX_APERTURE_M:g} m at most); "
                "are positions_m in metres?"
            )
        if not self.channels:
            object.__setattr__(self, "channels", tuple(range(shape[0])))
        if len(self.channels) != shape[0]:
            raise BadInput(f"There are {shape[0]} positions but {len(self.channels)} channels; each needs the other.")
        if len(set(self.channels)) != shape[0] or min(self.channels) < 0 or max(self.channels) > 1023:
            raise BadInput("channels must name a different channel, counted from 0, for every microphone.")
        if self.rate is not None and not 4_000 <= self.rate <= 192_000:
            raise BadInput("sample_rate_hz must lie between 4,000 and 192,000.")
        if not 250 <= self.speed <= 2_000 or not 0 <= self.position_sd <= 0.1:
            raise BadInput("The speed of sound must lie between 250 and 2,000 m/s, position_sd_m between 0 and 0.1.")

    @property
    def pairs(self) -> Array:
        """Microphones i < j of every pair, (P, 2)."""
        return np.column_stack(np.triu_indices(len(self.positions), 1))

    @property
    def baselines(self) -> Array:
        """Position of j minus position of i for every pair, (P, 3) [m]."""
        pairs = self.pairs
        return self.positions[pairs[:, 1]] - self.positions[pairs[:, 0]]

    @property
    def axes(self) -> tuple[Array, Array]:
        """Main directions (3, 3), one a row, widest first, and the array's extent (3,) [m] along each."""
        extent, axes = np.linalg.svd(self.positions - self.positions.mean(0), full_matrices=True)[1:]
        return axes, np.pad(extent, (0, 3 - len(extent)))

    @property
    def dimensions(self) -> int:
        """0 one point, 1 a line, 2 a plane, 3 a volume."""
        extent = self.axes[1]
        return int(np.count_nonzero(extent > max(FLAT_SHARE * float(extent[0]), 1e-4)))

    @property
    def normal(self) -> Array:
        """(3,): at right angles to a flat array, on the side of z up where that says anything."""
        normal = self.axes[0][2]
        return normal * math.copysign(1.0, normal @ np.array([1e-6, 1e-3, 1.0]))

    def heard(self, sound: Sound) -> Array:
        """The sound's samples (N, M) in the order of `positions`. Raises BadInput where they do not fit, or are no
        numbers.
        """
        if max(self.channels) >= sound.channels:
            raise BadInput(
                f"The sound has {sound.channels} channel{'s' * (sound.channels > 1)}, but the array {self.name} "
                f"wants channel {max(self.channels)} (counted from 0); choose another array profile."
            )
        if self.rate is not None and self.rate != sound.rate:
            raise BadInput(
                f"The sound has {sound.rate} Hz, but the array {self.name} delivers {self.rate} Hz; is it its sound?"
            )
        samples = sound.samples[:, list(self.channels)]
        if not usable(samples):
            raise BadInput(NO_NUMBERS)
        return samples


def ring(name: str, radius: float, first: float, step: float, count: int) -> MicrophoneArray:
    """`count` microphones on a level circle, from azimuth `first` in steps of `step` [rad]."""
    angles = first + step * np.arange(count)
    return MicrophoneArray(
        name=name, positions=np.column_stack((radius * np.cos(angles), radius * np.sin(angles), 0 * angles))
    )


def tetrahedron(radius: float = 0.05) -> MicrophoneArray:
    """Four microphones at the corners of a regular tetrahedron."""
    corners = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    return MicrophoneArray(name="tetrahedron", positions=corners * radius / math.sqrt(3))


RESPEAKER_ODAS = MicrophoneArray(
    name="ReSpeaker 4-mic square, frame of ODAS",
    positions=np.array([[-0.032, 0, 0], [0, -0.032, 0], [0.032, 0, 0], [0, 0.032, 0]]),
)
RESPEAKER_BOARD = MicrophoneArray(
    name="ReSpeaker 4-mic square, frame of the board's drawing",
    positions=np.array([[1.0, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]) * 0.02285,
)
ARRAYS = {
    "respeaker-odas": RESPEAKER_ODAS,
    "respeaker-board": RESPEAKER_BOARD,
    "tetrahedron": tetrahedron(),
    "ring-6": ring("six on a circle", 0.0463, 0.0, math.pi / 3, 6),
}
"""Profiles that need no file. The two frames of the ReSpeaker are the same board, 45° apart."""


def load_array(path: str | Path) -> MicrophoneArray:
    """An array profile: one of ARRAYS by name, or a TOML file. Raises BadInput with a sentence."""
    if str(path) in ARRAYS:
        return ARRAYS[str(path)]
    file = Path(path)
    try:
        if file.stat().st_size > MAX_PROFILE_BYTES:
            raise BadInput(f"{file.name} is too large for an array profile; a few lines are expected.")
        fields = tomllib.loads(text_of(file.read_bytes(), file.name))
    except (tomllib.TOMLDecodeError, RecursionError) as trouble:
        raise BadInput(f"{file.name} is not valid TOML: {trouble}.") from None
    except (OSError, ValueError):
        raise BadInput(
            f"The array profile {file.name[:60]} cannot be read; give a TOML file or one of {', '.join(ARRAYS)}."
        ) from None
    return array_of(fields, file.stem)


def array_of(fields: Mapping[str, object], name: str = "microphones") -> MicrophoneArray:
    """The keys of a profile (`positions_m`, `channels`, …) → the array. Raises BadInput."""
    unknown = [key for key in fields if key not in KEYS]
    if unknown:
        raise BadInput(f"The array profile has an unknown key {unknown[0][:40]!r}; known are {', '.join(KEYS)}.")
    if "positions_m" not in fields:
        raise BadInput("The array profile needs positions_m = [[x, y, z], …] in metres.")
    positions = _positions(fields["positions_m"])
    _check_places(positions)
    return MicrophoneArray(
        positions=positions,
        channels=_channels(fields.get("channels", [])),
        name=_text(fields.get("name", name)),
        rate=None if "sample_rate_hz" not in fields else _whole(fields["sample_rate_hz"]),
        speed=_number(fields.get("speed_of_sound_m_s", 343.0), "speed_of_sound_m_s"),
        position_sd=_number(fields.get("position_sd_m", 0.0005), "position_sd_m"),
    )


def _positions(value: object) -> Array:
    rows = value if isinstance(value, list) else []
    if not rows or any(not isinstance(row, list) or len(row) != 3 for row in rows):
        raise BadInput("positions_m needs rows of three numbers [x, y, z] in metres.")
    return np.array([[_number(number, "positions_m") for number in row] for row in rows])


def _check_places(positions: Array) -> None:
    """Raise BadInput where two of the positions (M, 3) [m] are one, or all lie closer than any board has them."""
    distances = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    first, second = np.triu_indices(len(positions), 1)
    apart = distances[first, second]
    if 0.0 < (widest := float(apart.max(initial=0.0))) < MIN_APERTURE_M:
        raise BadInput(
            f"All microphones lie within {1000 * widest:.2g} mm, where sound has no direction; "
            "are positions_m in metres?"
        )
    if len(apart) and apart.min() < MIN_APART_M:
        pair = int(apart.argmin())
        raise BadInput(
            f"positions_m puts microphones {first[pair]} and {second[pair]} (counted from 0) at one place; "
            "measure both."
        )


def _channels(value: object) -> tuple[int, ...]:
    if not isinstance(value, list):
        raise BadInput("channels must be a list of whole numbers, counted from 0.")
    return tuple(_whole(number) for number in value)


def _text(value: object) -> str:
    if not isinstance(value, str) or not value.isprintable() or len(value) > 200:
        raise BadInput("The array's name must be a short text.")
    return value


def _whole(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or abs(value) > 10**9:
        raise BadInput("channels and sample_rate_hz must be whole numbers.")
    return value


def _number(value: object, key: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not -MAX_NUMBER < value < MAX_NUMBER:
        raise BadInput(f"{key} must hold finite numbers only.")
    return float(value)
