"""Pictures and sound of strangers' bags: every encoding gives the colours and the samples that went in."""

import io
import itertools
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
import soundfile
from rosbags.typesys import get_types_from_msg

from core.errors import BadInput
from core.pilot.replayed_drive import open_robot
from core.recording import LogSettings, open_log
from core.recording.read_report import ReadReport
from core.recording.recorded_senses import RecordedImage, sights
from core.recording.ros_pictures import raw_pixels
from core.recording.ros_sound import SampleForm
from core.robots.requests import Play, Seek
from tests.core.recording.log_writers import ROS1, ROS2, START, one, robot_messages, two, write_bag, write_folder
from tests.core.recording.log_writers import write_mcap as write_plain_mcap

for _store in (ROS1, ROS2):
    for _name, _text in {
        "AudioData": "uint8[] data",
        "AudioInfo": "uint8 channels\nuint32 sample_rate\nstring sample_format\nuint32 bitrate\nstring coding_format",
        "AudioDataStamped": "std_msgs/Header header\naudio_common_msgs/AudioData audio",
    }.items():
        _store.register(get_types_from_msg(_text, f"audio_common_msgs/msg/{_name}"))
    _store.register(
        get_types_from_msg(
            "builtin_interfaces/Time timestamp\nuint8[] data\nstring format\nuint32 sample_rate\n"
            "uint32 number_of_channels",
            "foxglove_msgs/msg/RawAudio",
        )
    )

FORMS = {
    "bag": lambda folder, messages: write_bag(folder / "log.bag", messages(one)),
    "db3": lambda folder, messages: write_folder(folder / "log", messages(two)),
    "mcap": lambda folder, messages: write_plain_mcap(folder / "log.mcap", messages(two)),
}

# pictures: patches of known colours

PATCH = 32  # [pixel]
PATCH_COLOURS = np.array(  # red, green, blue
    [[220, 30, 40], [20, 200, 60], [30, 50, 230], [128, 128, 128], [240, 200, 90], [10, 12, 20]], np.uint8
)
RGB = np.kron(PATCH_COLOURS.reshape(2, 3, 3), np.ones((PATCH, PATCH, 1), np.uint8))
GREY = np.rint(RGB @ np.array([0.299, 0.587, 0.114]))


def centres(pixels):
    """The colour in the middle of every patch (6, 3), blue-green-red."""
    return pixels[PATCH // 2 :: PATCH, PATCH // 2 :: PATCH].reshape(-1, 3).astype(int)


def mosaic(pattern, pixels=RGB):
    """What a sensor under a filter sees: `pattern` names the colours of the upper two and the lower two pixels."""
    seen = np.zeros(pixels.shape[:2], pixels.dtype)
    for number, colour in enumerate(pattern):
        rows, columns = slice(number // 2, None, 2), slice(number % 2, None, 2)
        seen[rows, columns] = pixels[rows, columns, "rgb".index(colour)]
    return seen


def yuv422(order):
    """ITU-R BT.601: two pixels share u and v."""
    r, g, b = (RGB[..., number] / 255 for number in range(3))
    y = 16 + 65.481 * r + 128.553 * g + 24.966 * b
    u = 128 - 37.797 * r - 74.203 * g + 112 * b
    v = 128 + 112 * r - 93.786 * g - 18.214 * b
    shared = np.zeros(r.shape)
    shared[:, ::2], shared[:, 1::2] = u[:, ::2], v[:, ::2]
    planes = {"y": y, "c": shared}
    return np.rint(np.stack([planes[one] for one in order], axis=-1)).astype(np.uint8)


ALPHA = np.full((*RGB.shape[:2], 1), 77, np.uint8)
WIDE = RGB.astype(np.uint16) * 257
ENCODED = {
    "rgb8": RGB,
    "bgr8": RGB[..., ::-1],
    "8UC3": RGB[..., ::-1],
    "rgba8": np.concatenate([RGB, ALPHA], axis=-1),
    "bgra8": np.concatenate([RGB[..., ::-1], ALPHA], axis=-1),
    "rgb16": WIDE,
    "bgr16": WIDE[..., ::-1],
    "mono8": GREY.astype(np.uint8),
    "8UC1": GREY.astype(np.uint8),
    "mono16": GREY.astype(np.uint16) * 257,
    "mono16 big-endian": (GREY.astype(np.uint16) * 257).astype(">u2"),
    "yuv422": yuv422("cy"),
    "uyvy": yuv422("cy"),
    "yuv422_yuy2": yuv422("yc"),
    "yuyv": yuv422("yc"),
    **{f"bayer_{pattern}8": mosaic(pattern) for pattern in ("rggb", "bggr", "gbrg", "grbg")},
    **{f"bayer_{pattern}16": mosaic(pattern, WIDE) for pattern in ("rggb", "bggr", "gbrg", "grbg")},
}
PACKED = {
    "jpeg": cv2.imencode(".jpg", RGB[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 98])[1],
    "png": cv2.imencode(".png", RGB[..., ::-1])[1],
    "rgb8; jpeg compressed bgr8": cv2.imencode(".jpg", RGB[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 98])[1],
    "bgr8; png compressed bgr8": cv2.imencode(".png", RGB[..., ::-1])[1],
    "mono8; png compressed ": cv2.imencode(".png", GREY.astype(np.uint8))[1],
    "mono16; png compressed ": cv2.imencode(".png", GREY.astype(np.uint16) * 257)[1],
}


def expected(name):
    """The colours of the patches (6, 3), blue-green-red."""
    grey = name.startswith(("mono", "8UC1"))
    return centres(np.repeat(GREY[..., None], 3, axis=-1) if grey else RGB[..., ::-1])


def raw(name, padding=0):
    """The fields of a sensor_msgs/Image; every row is followed by `padding` bytes."""
    rows = np.ascontiguousarray(ENCODED[name]).view(np.uint8).reshape(len(RGB), -1)
    rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=99)
    return {
        "height": RGB.shape[0],
        "width": RGB.shape[1],
        "encoding": name.split()[0],
        "is_bigendian": int(name.endswith("big-endian")),
        "step": rows.shape[1],
        "data": rows.ravel(),
    }


@pytest.mark.parametrize("name", ENCODED)
@pytest.mark.parametrize("padding", [0, 6])
def test_a_raw_picture_has_the_colours_that_its_encoding_says(name, padding):
    seen = raw_pixels(SimpleNamespace(**raw(name, padding)))
    assert seen.shape == RGB.shape and seen.dtype == np.uint8
    assert np.abs(centres(seen) - expected(name)).max() <= 2


@pytest.mark.parametrize("change", [{"encoding": "32FC1"}, {"step": 3}, {"height": 65}, {"width": 0}])
def test_a_raw_picture_that_does_not_fit_its_data_or_is_of_another_kind_is_refused(change):
    with pytest.raises(BadInput):
        raw_pixels(SimpleNamespace(**raw("rgb8") | change))


def picture_messages(kind, packed):
    """Scans, and a picture of every encoding between them, all on one topic."""
    told = robot_messages(kind, scans=40)
    for number, name in enumerate(PACKED if packed else ENCODED):
        stamp = START + 0.1 + 0.1 * number
        header = kind.header(stamp, "camera")
        if packed:
            fields, name = {"format": name, "data": PACKED[name].ravel()}, "CompressedImage"
        else:
            fields, name = raw(name), "Image"
        name = f"sensor_msgs/msg/{name}"
        told.append(("/camera/image", name, stamp, kind.types[name](header=header, **fields)))
    return sorted(told, key=lambda row: row[2])


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("form", FORMS)
def test_pictures_of_every_encoding_come_out_of_every_form_of_bag(form, packed, tmp_path):
    log = open_log(FORMS[form](tmp_path, lambda kind: picture_messages(kind, packed)), whole=True)
    names = list(PACKED if packed else ENCODED)
    assert len(log.pictures) == len(names) and log.report.skipped == 0
    for name, seen in zip(names, log.pictures, strict=True):
        assert np.abs(centres(seen.pixels) - expected(name)).max() <= 6, name  # they are kept as JPEG


# cameras: whose pictures, model and place


def camera_info(kind, stamp, frame, focal):
    """The CameraInfo of a camera without distortion, whose pictures are those above."""
    name = "sensor_msgs/msg/CameraInfo"
    height, width = RGB.shape[:2]
    k = np.array([focal, 0, width / 2, 0, focal, height / 2, 0, 0, 1.0])
    names = "DKRP" if kind.ros1 else "dkrp"
    numbers = dict(zip(names, (np.zeros(5), k, np.eye(3).ravel(), np.zeros(12)), strict=True))
    region = kind.types["sensor_msgs/msg/RegionOfInterest"](
        x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
    )
    fields = {"height": height, "width": width, "distortion_model": "plumb_bob", "binning_x": 0, "binning_y": 0}
    return kind.types[name](header=kind.header(stamp, frame), roi=region, **fields, **numbers)


def cameras_messages(kind, described=True, focal=200.0):
    """Scans, depth pictures, and those of a left camera, whose right neighbour's CameraInfo comes first."""
    told = robot_messages(kind, scans=20)
    make, image, info = kind.types, "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
    far = {"height": 4, "width": 4, "encoding": "16UC1", "is_bigendian": 0, "step": 8, "data": np.zeros(32, np.uint8)}
    for number in range(10):
        stamp = START + 0.1 + 0.1 * number
        told.append(("/depth/image", image, stamp, make[image](header=kind.header(stamp, "depth"), **far)))
        told.append(("/right/camera_info", info, stamp, camera_info(kind, stamp, "right_optical", 300.0)))
        left = kind.header(stamp + 0.01, "left_optical")
        told.append(("/left/image_raw", image, stamp + 0.01, make[image](header=left, **raw("bgr8"))))
        if described:
            told.append(("/left/camera_info", info, stamp + 0.02, camera_info(kind, stamp, "left_optical", focal)))
    if described:
        placed = kind.tf(START, "base_link", "left_optical", (0.3, 0.1, 0.0), height=0.5)
        told.append(("/tf_static", "tf2_msgs/msg/TFMessage", START, placed))
    return sorted(told, key=lambda row: row[2])


@pytest.mark.parametrize("form", FORMS)
def test_of_several_cameras_one_that_sees_is_used_with_its_own_model_and_place(form, tmp_path):
    path = FORMS[form](tmp_path, cameras_messages)
    log = open_log(path, whole=True)
    assert "/left/image_raw: camera" in log.report.topics and log.camera.model.fx == 200.0
    assert log.camera.mounting.translation == pytest.approx([0.3, 0.1, 0.5])
    assert not [one for one in log.report.faults if one.code.startswith("camera")]
    tally = ReadReport(path)
    seen = [one for one in sights(path, LogSettings(), tally) if isinstance(one, RecordedImage)]
    assert len(seen) == 10 and seen[-1].model is not None and seen[-1].model.fx == 200.0


@pytest.mark.parametrize("form", FORMS)
def test_a_camera_that_the_log_does_not_describe_is_guessed_and_that_is_said(form, tmp_path):
    path = FORMS[form](tmp_path, lambda kind: cameras_messages(kind, described=False))
    log = open_log(path, whole=True)
    assert log.camera.model.fx == pytest.approx(0.9 * RGB.shape[1])
    found = {one.code: one for one in log.report.faults if one.code.startswith("camera")}
    assert set(found) == {"camera.guessed", "camera.unplaced"}
    assert all(one.used and "/left/image_raw" in one.sentence for one in found.values())
    seen = [one for one in sights(path, LogSettings(), ReadReport(path)) if isinstance(one, RecordedImage)]
    assert len(seen) == 10 and all(one.model is None for one in seen)


@pytest.mark.parametrize(("widths", "code"), [(8.0, "camera.view"), (0.005, "camera.guessed")])
def test_a_camera_info_that_hardly_can_be_is_said_and_one_that_cannot_is_not_used(widths, code, tmp_path):
    focal = widths * RGB.shape[1]
    path = FORMS["mcap"](tmp_path, lambda kind: cameras_messages(kind, focal=focal))
    log = open_log(path, whole=True)
    assert [one.code for one in log.report.faults if one.code.startswith("camera")] == [code]
    assert (log.camera.model.fx == focal) == (code == "camera.view")


# sound: a tone per channel

RATE_HZ, BLOCK = 16_000, 320  # samples
TONES = 0.4 * np.sin(2 * np.pi * np.arange(40 * BLOCK)[:, None] * np.array([0.01, 0.023, 0.031, 0.05, 0.07, 0.11]))


def s24(order):
    whole = np.rint(TONES[:, :1] * 2**23).astype("<i4").view(np.uint8).reshape(-1, 4)[:, :3]
    return whole if order == "<" else whole[:, ::-1]


def mp3():
    packed = io.BytesIO()
    soundfile.write(packed, TONES[:, 0], RATE_HZ, format="MP3")
    return np.frombuffer(packed.getvalue(), np.uint8)


SOUNDS = {  # channels, GStreamer's name of the samples, bytes
    "/one/S16LE": (1, "S16LE", np.rint(TONES[:, :1] * 32768).astype("<i2")),
    "/six/S16LE": (6, "S16LE", np.rint(TONES * 32768).astype("<i2")),
    "/two/S16BE": (2, "S16BE", np.rint(TONES[:, :2] * 32768).astype(">i2")),
    "/one/U8": (1, "U8", np.rint(TONES[:, :1] * 128 + 128).astype(np.uint8)),
    "/one/S8": (1, "S8", np.rint(TONES[:, :1] * 128).astype(np.int8)),
    "/one/S24LE": (1, "S24LE", s24("<")),
    "/one/S24BE": (1, "S24BE", s24(">")),
    "/four/S32LE": (4, "S32LE", np.rint(TONES[:, :4] * 2**31).astype("<i4")),
    "/one/F32LE": (1, "F32LE", TONES[:, :1].astype("<f4")),
    "/one/F64BE": (1, "F64BE", TONES[:, :1].astype(">f8")),
    "/one/mp3": (1, "S16LE", mp3()),
}


def cut(content, blocks=40):
    """Bytes in blocks, as they come in a second."""
    flat = np.ascontiguousarray(content).view(np.uint8).ravel()
    return np.array_split(flat, blocks) if len(flat) % blocks else np.split(flat, blocks)


def sound_messages(kind, informed=True, topics=tuple(SOUNDS), stamped=False):
    """Scans, sound in blocks of 20 ms, and an AudioInfo beside each topic, which comes after some blocks."""
    told = robot_messages(kind, scans=20)
    make = kind.types
    for topic in topics:
        channels, samples, content = SOUNDS[topic]
        for number, block in enumerate(cut(content)):
            came = START + 0.02 * (number + 1)
            data, name = make["audio_common_msgs/msg/AudioData"](data=block), "audio_common_msgs/msg/AudioData"
            if stamped:
                data = make[f"{name}Stamped"](header=kind.header(START + 0.02 * number, "microphone"), audio=data)
                name = f"{name}Stamped"
            told.append((f"{topic}/audio", name, came, data))
        if informed:
            name = "audio_common_msgs/msg/AudioInfo"
            coding = "mp3" if topic.endswith("mp3") else "wave"
            info = make[name](channels=channels, sample_rate=RATE_HZ, sample_format=samples, bitrate=0,
                              coding_format=coding)  # fmt: skip
            told.append((f"{topic}/audio_info", name, START + 0.1, info))
    return sorted(told, key=lambda row: row[2])


@pytest.mark.parametrize("form", FORMS)
def test_sound_of_every_sample_form_comes_out_of_every_form_of_bag(form, tmp_path):
    path = FORMS[form](tmp_path, sound_messages)
    for topic, (channels, samples, _) in SOUNDS.items():
        log = open_log(path, LogSettings(sound_topic=f"{topic}/audio"), whole=True)
        (heard,) = log.sounds
        assert (heard.rate, heard.channels) == (RATE_HZ, channels), topic
        assert heard.stamp == pytest.approx(START, abs=0.021), topic
        if topic.endswith("mp3"):  # its coder delays the sound, and leaves something out
            lag = np.argmax(np.correlate(heard.samples[:4000, 0], TONES[:1000, 0], "valid"))
            found = heard.samples[lag : lag + 4000, 0]
            assert np.corrcoef(found, TONES[:4000, 0])[0, 1] > 0.99
        else:
            step = {"U8": 2**-7, "S8": 2**-7}.get(samples, 2**-14)
            assert np.abs(heard.samples - TONES[:, :channels]).max() < step, topic


@pytest.mark.parametrize("topic", ["/one/S16LE", "/six/S16LE"])
def test_sound_that_says_no_rate_is_measured_by_its_bytes_and_that_is_said(topic, tmp_path):
    log = open_log(
        FORMS["mcap"](tmp_path, lambda kind: sound_messages(kind, informed=False, topics=(topic,))), whole=True
    )
    fault = next(one for one in log.report.faults if one.code == "sound.no_rate")
    rate, channels = log.sounds[0].rate, log.sounds[0].channels
    assert rate * channels == RATE_HZ * SOUNDS[topic][0]
    assert fault.used and f"{rate} Hz and {channels} of 16 bits" in fault.sentence
    settings = LogSettings(sound_rate=RATE_HZ, sound_channels=SOUNDS[topic][0])
    told = open_log(tmp_path / "log.mcap", settings, whole=True)
    assert (told.sounds[0].rate, told.sounds[0].channels) == (RATE_HZ, SOUNDS[topic][0])
    assert not told.report.faults


def test_stamped_sound_begins_at_its_stamp_and_a_gap_begins_a_new_piece(tmp_path):
    def with_gap(kind):
        told = sound_messages(kind, topics=("/one/S16LE",), stamped=True)
        return [row for row in told if "audio" not in row[0] or not START + 0.2 < row[2] < START + 0.75]

    log = open_log(FORMS["db3"](tmp_path, with_gap), whole=True)
    first, second = log.sounds
    assert first.stamp == pytest.approx(START) and first.duration == pytest.approx(0.2)
    assert second.stamp == pytest.approx(START + 0.74, abs=0.021)
    assert second.newest == pytest.approx(START + 0.8)


@pytest.mark.parametrize("samples", ["S16", "U16LE", "S32BE", "F32BE"])
def test_samples_keep_their_value_in_every_order_of_bytes(samples):
    kind = f"{'>' if samples.endswith('BE') else '<'}{samples[0].lower().replace('s', 'i')}{int(samples[1:3]) // 8}"
    scale = 1.0 if samples[0] == "F" else 2.0 ** (int(samples[1:3]) - 1)
    content = (TONES[:, :2] * scale + scale * (samples[0] == "U")).astype(kind).tobytes()
    assert np.abs(SampleForm(RATE_HZ, 2, samples).samples_of(content) - TONES[:, :2]).max() < 2**-14


def test_a_bag_that_is_played_is_heard_to_its_last_sample_and_again_after_a_seek(tmp_path):
    path = FORMS["bag"](tmp_path, lambda kind: sound_messages(kind, topics=("/two/S16BE",)))
    robot = open_robot(str(path), seed=0, settings=None)
    for _ in range(2):
        robot.ask(Seek(value=0.0))
        robot.ask(Play())
        frames = list(itertools.takewhile(lambda frame: frame.running, (robot.read() for _ in range(10_000))))
        heard = np.concatenate([frame.sound.samples for frame in frames if frame.sound is not None])
        assert np.abs(heard - TONES[:, :2]).max() < 2**-14
        assert all(frame.sound.newest <= frame.stamp + 1e-6 for frame in frames if frame.sound is not None)
