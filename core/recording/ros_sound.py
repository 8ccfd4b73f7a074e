"""Sound among ROS messages: the types in which robots send it, and their bytes → samples.

`audio_common_msgs/AudioData` says neither rate nor channels; an AudioInfo beside it does, else the settings, else the
bytes per second by the recorder's clock. GStreamer's names of samples ("S16LE") and MP3 are read.
"""

import io
import re
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from rosbags.typesys import get_types_from_msg
from rosbags.typesys.store import Typestore

from core.install import install_packages
from core.message import Array
from core.recording.read_report import BadRecord, ReadReport
from core.recording.sound_file import decoded_samples
from core.sensors.microphones import MAX_MICROPHONES, Sound

RAW_AUDIO = "foxglove_msgs/msg/RawAudio"
AUDIO_DATA, AUDIO_INFO = "audio_common_msgs/msg/AudioData", "audio_common_msgs/msg/AudioInfo"
AUDIO_STAMPED = "audio_common_msgs/msg/AudioDataStamped"
SOUND_FIELDS = {
    RAW_AUDIO: "builtin_interfaces/Time timestamp\nuint8[] data\nstring format\n"
    "uint32 sample_rate\nuint32 number_of_channels\n",
    AUDIO_DATA: "uint8[] data\n",
    AUDIO_STAMPED: "std_msgs/Header header\naudio_common_msgs/AudioData audio\n"
    f"{'=' * 80}\nMSG: audio_common_msgs/AudioData\nuint8[] data\n",
    AUDIO_INFO: "uint8 channels\nuint32 sample_rate\nstring sample_format\nuint32 bitrate\nstring coding_format\n",
}
"""Message types that the usual collections leave out, with what they are made of."""

SAMPLE_FORM = re.compile(r"(S|U|pcm-s|F(?=32|64))(8|16|24|32|64)(LE|BE)?")
UNPACKED_CODINGS = frozenset({"", "wave", "wav", "pcm", "raw"})
PACKED_CODINGS = frozenset({"mp3", "ogg", "flac", "vorbis"})
RATES_HZ = (4_000, 192_000)  # that are believed
USUAL_FORMS = (
    *((rate, 1) for rate in (8_000, 16_000, 22_050, 24_000, 44_100, 48_000)),
    *((rate, 2) for rate in (16_000, 44_100, 48_000)),
    *((16_000, channels) for channels in (4, 6, 8)),
)
"""Rate [Hz] and channels that microphones usually have, the likeliest first."""
RATE_TOLERANCE = 0.05  # share by which the bytes per second may differ from a usual form
DEFAULT_RATE_HZ = 16_000  # of audio_capture
MAX_GAP_S = 0.5  # by which a block may come early or late and still follow the one before
MAX_SOUND_BYTES = 400_000_000


@dataclass(frozen=True)
class SampleForm:
    """The form of the bytes of a sound."""

    rate: int = DEFAULT_RATE_HZ  # [Hz]
    channels: int = 1
    samples: str = "S16LE"
    coding: str = ""  # "mp3" …; "": plain samples

    @property
    def block_bytes(self) -> int:
        """The bytes of one sample of every channel. Raises BadRecord for a form that is not read."""
        return self.channels * self._width

    @property
    def _width(self) -> int:
        known = SAMPLE_FORM.fullmatch(self.samples)
        if known is None:
            raise BadRecord(f"its samples are {self.samples[:20]!r}, which is not read")
        return int(known[2]) // 8

    def checked(self) -> Self:
        """The same form. Raises BadRecord for a rate, a number of channels or samples that cannot be."""
        if not (RATES_HZ[0] <= self.rate <= RATES_HZ[1] and 1 <= self.channels <= MAX_MICROPHONES):
            raise BadRecord("its sound has no usable rate or number of channels")
        if not self.coding:
            _ = self.block_bytes
        return self

    def samples_of(self, packed: bytes) -> Array:
        """Bytes → samples (N, C) float32, full scale ±1; what is left of a block at the end is left out."""
        whole = packed[: len(packed) // self.block_bytes * self.block_bytes]
        order = ">" if self.samples.endswith("BE") else "<"
        kind = "f" if self.samples[0] == "F" else "u" if self.samples[0] == "U" else "i"
        return decoded_samples(whole, kind, self._width, order).astype(np.float32).reshape(-1, self.channels)


def sound_in(content: Any, kind: str) -> tuple[SampleForm | None, bytes, float]:
    """A message with sound → its form where it says it, its bytes and its stamp [s], 0: none. Raises BadRecord."""
    if kind == RAW_AUDIO:
        if not str(content.format).startswith("pcm-"):
            raise BadRecord("its sound is compressed")
        form = SampleForm(int(content.sample_rate), int(content.number_of_channels), str(content.format))
        return form.checked(), bytes(content.data), content.timestamp.sec + content.timestamp.nanosec * 1e-9
    if kind == AUDIO_STAMPED:
        stamp = content.header.stamp
        return None, bytes(content.audio.data), stamp.sec + stamp.nanosec * 1e-9
    return None, bytes(content.data), 0.0


def is_packed_sound(packed: bytes) -> bool:
    """Return whether bytes begin as MP3, Ogg or FLAC do."""
    if packed.startswith((b"ID3", b"OggS", b"fLaC")):
        return True
    if len(packed) < 4 or packed[0] != 0xFF or packed[1] & 0xE6 != 0xE2:  # a frame of MPEG's layer 3
        return False
    return packed[2] >> 4 not in (0, 15) and packed[2] >> 2 & 3 != 3


@dataclass
class _SoundTopic:
    form: SampleForm | None = None  # as its messages say it
    packed: bytearray = field(default_factory=bytearray)
    blocks: list[tuple[float, float, int]] = field(default_factory=list[tuple[float, float, int]])
    """Stamp and time by the recorder [s], place of the first byte."""
    stamped: bool = False


class RosSounds:
    """Takes the sound of every topic that sends any, and makes that of one at the end."""

    def __init__(self, topic: str = "", rate: int = 0, channels: int = 0) -> None:
        """`topic`: the one to use; `rate` [Hz] and `channels` of sound that does not say them; 0: measured."""
        self._wanted, self._rate, self._channels = topic.strip("/"), rate, channels
        self._topics: dict[str, _SoundTopic] = {}
        self._infos: dict[str, SampleForm] = {}
        self._held = 0

    def take(self, topic: str, content: Any, kind: str, logged: float) -> bool:
        """Take a message's content, which came at `logged` [s] → whether it is kept. Raises BadRecord."""
        if kind == AUDIO_INFO:
            self._infos[topic] = _described(content)
            return False
        form, packed, stamp = sound_in(content, kind)
        if self._held > MAX_SOUND_BYTES:
            return False
        known = self._topics.setdefault(topic, _SoundTopic(form))
        if form != known.form:
            raise BadRecord("its sound has another form than before")
        known.stamped = stamp > 0
        known.blocks.append((stamp or logged, logged, len(known.packed)))
        known.packed += packed
        self._held += len(packed)
        return True

    def finish(self, tally: ReadReport) -> tuple[Sound, ...]:
        """The pieces of one topic in order of time; a gap begins a new piece."""
        names = [name for name in self._topics if not self._wanted or name.strip("/") == self._wanted]
        if not names:
            return ()
        name = max(names, key=lambda one: len(self._topics[one].packed))
        if others := sorted(set(self._topics) - {name}):
            tally.warn(
                f"Of several microphones {name} is used; {', '.join(others[:5])} is not. "
                "Set log.sound_topic to change that."
            )
        if self._held > MAX_SOUND_BYTES:
            tally.warn(f"The log holds more than {MAX_SOUND_BYTES // 10**6} MB of sound; the rest is left out.")
        try:
            topic = self._topics[name]
            form = (topic.form or self._form(name, topic, tally)).checked()
            pieces = _unpacked(topic) if form.coding else _pieces(topic, form)
        except BadRecord as problem:
            tally.drop(str(problem), count=len(self._topics[name].blocks))
            return ()
        tally.topics.append(f"{name}: microphones")
        return pieces

    def _form(self, name: str, topic: _SoundTopic, tally: ReadReport) -> SampleForm:
        """The form of sound that does not say it itself."""
        info = self._info_of(name)
        packed = is_packed_sound(bytes(topic.packed[:8]))
        if info is not None:
            return SampleForm(info.rate, info.channels, info.samples, "mp3") if packed else info
        if packed:
            return SampleForm(coding="mp3")  # the bytes say the rest
        if self._rate or self._channels:
            return SampleForm(self._rate or DEFAULT_RATE_HZ, self._channels or 1)
        form, why = _measured(topic)
        tally.fault("sound.no_rate", name, used=True, rate=form.rate, channels=form.channels, why=why)
        return form

    def _info_of(self, name: str) -> SampleForm | None:
        """The AudioInfo beside a topic; of several the one whose name has the longest common beginning."""

        def common(other: str) -> int:
            return next((at for at, (a, b) in enumerate(zip(name, other, strict=False)) if a != b), len(name))

        best = max(self._infos, key=common, default=None)
        return None if best is None else self._infos[best]


def with_sound(store: Typestore) -> Typestore:
    """The same types with those in which robots send sound."""
    for name, text in SOUND_FIELDS.items():
        if name not in store.types:
            made_of = get_types_from_msg(text, name)
            store.register({known: of for known, of in made_of.items() if known not in store.types})
    return store


def _described(content: Any) -> SampleForm:
    coding = str(content.coding_format).strip().lower()
    if coding not in UNPACKED_CODINGS | PACKED_CODINGS:
        raise BadRecord(f"its sound is coded as {coding[:20]!r}, which is not read")
    samples = str(content.sample_format).strip().upper() or "S16LE"
    return SampleForm(
        int(content.sample_rate), int(content.channels), samples, "" if coding in UNPACKED_CODINGS else coding
    )


def _measured(topic: _SoundTopic) -> tuple[SampleForm, str]:
    (_, first, _), (_, last, place) = topic.blocks[0], topic.blocks[-1]
    per_second = place / (last - first) if last > first else 0.0
    for rate, channels in USUAL_FORMS:
        if abs(per_second / (2 * rate * channels) - 1) < RATE_TOLERANCE:
            return SampleForm(rate, channels), f"{per_second:.0f} bytes came in a second"
    return SampleForm(), "drivers usually send"


def _pieces(topic: _SoundTopic, form: SampleForm) -> tuple[Sound, ...]:
    """Plain samples; a block follows the one before unless it comes much later or earlier."""
    per_second = form.rate * form.block_bytes
    ends = [at for _, _, at in topic.blocks[1:]] + [len(topic.packed)]
    first_s = 0.0 if topic.stamped else ends[0] / per_second  # a block without a stamp came when it was complete
    begins = [0]  # bytes where a piece begins
    starts = [topic.blocks[0][0] - first_s]
    for number in range(1, len(topic.blocks)):
        stamp, _, at = topic.blocks[number]
        length_s = 0.0 if topic.stamped else (ends[number] - at) / per_second
        if abs(stamp - length_s - starts[-1] - (at - begins[-1]) / per_second) > MAX_GAP_S:
            begins.append(at)
            starts.append(stamp - length_s)
    sounds: list[Sound] = []
    for start, begin, end in zip(starts, begins, [*begins[1:], len(topic.packed)], strict=True):
        samples = form.samples_of(bytes(topic.packed[begin:end]))
        if len(samples):
            sounds.append(Sound(stamp=start, rate=form.rate, samples=samples))
    return tuple(sounds)


def _unpacked(topic: _SoundTopic) -> tuple[Sound, ...]:
    """Packed sound is unpacked as a whole. Raises BadRecord."""
    try:
        import soundfile
    except (ImportError, OSError):
        raise BadRecord(f"packed sound needs soundfile: {install_packages('soundfile')}") from None
    try:
        with soundfile.SoundFile(io.BytesIO(bytes(topic.packed))) as file:
            rate, samples = int(file.samplerate), file.read(dtype="float32", always_2d=True)
    except (soundfile.SoundFileError, RuntimeError):
        raise BadRecord("its packed sound is damaged, or of a kind that is not read") from None
    return (Sound(stamp=topic.blocks[0][0], rate=rate, samples=samples),) if len(samples) else ()
