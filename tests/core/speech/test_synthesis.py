"""Text to speech, where there is any; a sentence where there is none."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput, Unavailable
from core.install import install_extra
from core.speech.synthesis import VoiceSettings, _bundled, by_library, by_program, can_speak, speak

speaking = pytest.mark.skipif(not can_speak(), reason="nothing here speaks: pip install espeakng-loader")


def test_without_a_speaker_a_sentence_says_what_to_install() -> None:
    with pytest.raises(Unavailable, match=re.escape(install_extra("voice"))):
        speak("turn left", speakers=())


def test_the_program_that_is_not_there_is_no_voice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(Unavailable, match="espeak-ng"):
        by_program("turn left", VoiceSettings())


def test_the_program_of_the_system_speaks_when_the_package_is_absent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "espeak-ng"  # a program of the same manners: text in, WAV without a length out
    program.write_text(
        "#!/bin/sh\ncat >/dev/null\n"
        "printf 'RIFF\\377\\377\\377\\177WAVEfmt \\020\\000\\000\\000\\001\\000\\001\\000\\042\\126\\000\\000'\n"
        "printf '\\104\\254\\000\\000\\002\\000\\020\\000data\\000\\360\\377\\177'\nprintf '\\000\\100\\000\\300'\n"
    )
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    sound = speak("turn left", speakers=(by_program,))
    assert sound.rate == 22050
    assert sound.samples.ravel().tolist() == [0.5, -0.5]


@pytest.mark.parametrize("text", ["", "…!", "stop " * 200])
def test_what_cannot_be_said_is_refused(text: str) -> None:
    with pytest.raises(BadInput):
        speak(text)


def test_an_unknown_voice_is_refused_with_those_that_are_known() -> None:
    with pytest.raises(BadInput, match="en-us"):
        VoiceSettings(voice="klingon; rm -rf")


@speaking
def test_a_longer_sentence_lasts_longer() -> None:
    one, longer = speak("turn left"), speak("turn left and then go on for three meters")
    assert 0.3 < one.duration < 2.0
    assert longer.duration > 2 * one.duration
    assert 0.05 < np.abs(one.samples).max() <= 1.0


@speaking
def test_voices_differ() -> None:
    lengths = {speak("come here", VoiceSettings(voice=voice)).samples.tobytes() for voice in ("en-us", "en-us+f2")}
    assert len(lengths) == 2


@speaking
def test_the_same_words_are_the_same_sound_whatever_was_said_before() -> None:
    voice = VoiceSettings(voice="en-us+f5")
    first = speak("come here please", voice).samples
    speak("where did you put my keys", VoiceSettings(voice="en-gb"))
    np.testing.assert_array_equal(first, speak("come here please", voice).samples)


@speaking
def test_the_library_speaks_in_no_process_but_its_own() -> None:
    asked = """
import sys
loaded = []
sys.addaudithook(lambda event, of: loaded.append(of[0]) if event == "ctypes.dlopen" else None)
from core.speech.synthesis import by_library, VoiceSettings
by_library("turn left", VoiceSettings())
print(loaded)"""
    opened = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True).stdout
    assert "[" in opened
    assert "espeak" not in opened


@speaking
def test_markup_is_text_and_nothing_else() -> None:
    assert speak("<audio src='/etc/passwd'/> turn left [[pau]]", speakers=(by_library, by_program)).duration > 0.3


@speaking
def test_a_busy_computer_is_not_one_without_a_voice(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_slow(*_: object, **__: object) -> None:
        raise subprocess.TimeoutExpired("espeak-ng", 30)

    with monkeypatch.context() as patch:
        patch.setattr(subprocess, "run", too_slow)
        _bundled.cache_clear()
        with pytest.raises(Unavailable, match="very busy"):
            speak("turn left")
    assert len(speak("turn left").samples)  # it was slow once, and is there
