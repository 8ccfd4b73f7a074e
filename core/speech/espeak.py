"""A program of its own around the library of eSpeak NG: text on standard input → a WAV file on standard output.

Run as `python -I -S espeak.py LIBRARY DATA VOICE SPEED PITCH`. It imports nothing of Beckon and nothing imports it:
the library (GPL-3.0) is part of no other process. A new process for every text: the library's pitch flutters on, and
its hiss is drawn on, from text to text.
"""

import ctypes
import struct
import sys

SYNCHRONOUS_MODE, NO_EXIT = 2, 0x8000  # of espeak_Initialize
BY_CHARACTER, UTF_8 = 1, 1  # of espeak_Synth
SPEED_PARAMETER, PITCH_PARAMETER = 1, 3  # of espeak_SetParameter
HISS_SEED = 1


def main(path: str, data: str, voice: str, speed: str, pitch: str) -> int:
    """Speak once → 0, or the library's error."""
    raw, pieces = sys.stdin.buffer.read(), list[bytes]()

    def take(samples: int | None, count: int, _events: int | None) -> int:
        if samples and count > 0:
            pieces.append(ctypes.string_at(samples, 2 * count))
        return 0

    calls = ctypes.CDLL(path)
    rate = calls.espeak_Initialize(SYNCHRONOUS_MODE, 0, data.encode(), NO_EXIT)
    if rate <= 0:
        return 1
    calls.espeak_ng_SetRandSeed(ctypes.c_long(HISS_SEED))
    callback = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)(take)
    calls.espeak_SetSynthCallback(callback)
    calls.espeak_SetVoiceByName(voice.encode())
    calls.espeak_SetParameter(SPEED_PARAMETER, int(speed), 0)
    calls.espeak_SetParameter(PITCH_PARAMETER, int(pitch), 0)
    trouble = calls.espeak_Synth(raw, ctypes.c_size_t(len(raw) + 1), 0, BY_CHARACTER, 0, UTF_8, None, None)
    sound = b"".join(pieces)
    form = struct.pack("<4sI4s4sIHHIIHH", b"RIFF", 36 + len(sound), b"WAVE", b"fmt ", 16, 1, 1, rate, 2 * rate, 2, 16)
    sys.stdout.buffer.write(form + struct.pack("<4sI", b"data", len(sound)) + sound)
    return int(trouble)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
