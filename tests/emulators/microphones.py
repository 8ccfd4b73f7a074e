"""A sound card with an array of microphones: what the simulated room sounds like, for a `sounddevice` of the tests.

The driver runs unchanged: with `environment()` it imports the stand-in of PortAudio in `sound_card/`, which gets
blocks of 16-bit samples over TCP.
"""

import contextlib
import os
from pathlib import Path

import numpy as np

from core.robots.usb_audio import RESPEAKER
from core.sensors.microphones import ARRAYS, Sound
from tests.emulators.wires import Port, TcpPort, Wire
from tests.emulators.world import World

PORT_NAME = "BECKON_TEST_SOUND_CARD"  # environment variable: where the stand-in finds the card
STAND_IN = Path(__file__).parent / "sound_card"
ARRAY = ARRAYS["respeaker-odas"]


class MicrophonesEmulator:
    """A ReSpeaker with its 6-channel firmware: processed, four raw, playback."""

    url = "audio://ReSpeaker"

    def __init__(self, world: World) -> None:
        world.on_sound.append(self._hear)
        self._port: Port = TcpPort(self._serve)

    @property
    def address(self) -> str:
        """Of the card, for PORT_NAME."""
        return self._port.url.removeprefix("//")

    def start(self) -> None:
        self._port.start()

    def stop(self) -> None:
        self._port.stop()

    def environment(self) -> dict[str, str]:
        """What a process needs to find this card."""
        path = os.pathsep.join(filter(None, (str(STAND_IN), os.environ.get("PYTHONPATH", ""))))
        return {PORT_NAME: self.address, "PYTHONPATH": path}

    def _serve(self, wire: Wire) -> None:
        while True:
            wire.read(1.0)

    def _hear(self, sound: Sound) -> None:
        wire = self._port.wire
        if wire is None or wire.cut.is_set():
            return
        with contextlib.suppress(OSError):
            wire.write(six_channels(sound))


def six_channels(sound: Sound) -> bytes:
    """(N, C) → 16-bit samples of all channels of the card, little endian."""
    samples = np.zeros((len(sound.samples), RESPEAKER["channels"]), "<i2")
    raw = np.round(sound.samples[:, list(ARRAY.channels)] * 32768).clip(-32768, 32767)
    first = RESPEAKER["first"]
    samples[:, [first + channel for channel in ARRAY.channels]] = raw
    samples[:, 0] = raw[:, 0]
    return samples.tobytes()
