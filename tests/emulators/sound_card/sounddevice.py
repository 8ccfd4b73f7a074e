"""A stand-in of the package sounddevice, for a process whose sound card is emulated (tests.emulators.microphones)."""

import os
import socket
import threading
from collections.abc import Callable
from typing import Any

import numpy as np


class PortAudioError(Exception):
    """As the package has it."""


class InputStream:
    """Blocks of samples from the emulated card, as PortAudio's own thread hands them over."""

    def __init__(
        self,
        *,
        device: object,
        channels: int,
        samplerate: int,
        blocksize: int,
        dtype: str,
        callback: Callable[[Any, int, Any, Any], None],
    ) -> None:
        host, _, port = os.environ["BECKON_TEST_SOUND_CARD"].rpartition(":")
        try:
            self._link = socket.create_connection((host, int(port)), 3.0)
        except OSError as trouble:
            raise PortAudioError(f"Error querying device {device}: {trouble}") from None
        self._link.settimeout(None)
        self._size, self._channels, self._dtype, self._callback = blocksize, channels, dtype, callback
        self._thread = threading.Thread(target=self._run, name="portaudio", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def abort(self) -> None:
        try:
            self._link.shutdown(socket.SHUT_RDWR)
        except OSError:
            return

    def close(self) -> None:
        self._link.close()

    def _run(self) -> None:
        length = self._size * self._channels * np.dtype(self._dtype).itemsize
        try:
            with self._link.makefile("rb") as blocks:
                while len(block := blocks.read(length)) == length:
                    samples = np.frombuffer(block, self._dtype).reshape(-1, self._channels)
                    self._callback(samples, self._size, None, None)
        except (OSError, ValueError):
            return  # it was unplugged or closed
