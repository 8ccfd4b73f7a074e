"""`beckon speech-quality --live --browser`: Chromium plays the sentences, and a file stands in for its microphone."""

import json
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser, expect

from core.errors import BeckonError
from core.experiments.live_speech_loop import LiveSpeechLoop
from core.experiments.speech_loop import RATE_HZ
from core.experiments.speech_quality import Setting, received_at, responses_at
from core.recording.sound_file import write_wav
from core.sensors.microphones import Sound
from tests.browser.visit import FLAT

TEXT = "turn left\nstop moving\n"
NEAR = Setting(sweep="distance", ratio=30.0, distance=0.5)
LONG = 120_000  # [ms]


@pytest.fixture(scope="module")
def chromium_flags(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """What a microphone in a room hears of the sentences, as a file: it begins when the page opens the microphone."""
    try:
        loop = LiveSpeechLoop(TEXT)
    except BeckonError as absent:
        pytest.skip(str(absent))
    heard = received_at(np.random.default_rng(1), loop.played, responses_at(NEAR), NEAR.ratio)
    quiet = 1e-4 * np.random.default_rng(2).normal(size=RATE_HZ // 2)
    samples = np.concatenate((quiet, 0.5 * heard / np.abs(heard).max(), quiet, np.zeros(60 * RATE_HZ)))
    file = tmp_path_factory.mktemp("room") / "room.wav"
    write_wav(file, Sound(stamp=0.0, rate=RATE_HZ, samples=samples[:, None]))
    return [
        *FLAT,
        "--use-fake-device-for-media-stream",
        "--use-fake-ui-for-media-stream",
        f"--use-file-for-fake-audio-capture={file}%noloop",
    ]


def test_the_loop_through_chromiums_loudspeaker_and_microphone(browser: Browser, tmp_path: Path) -> None:
    text = tmp_path / "text.txt"
    text.write_text(TEXT)
    out = tmp_path / "out"
    command = [sys.executable, "-m", "console", "speech-quality", "--live", "--browser", "--text", str(text)]
    with (
        subprocess.Popen(
            [*command, "--out", str(out), "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as program,
        ExitStack() as stop,
    ):
        stop.callback(program.kill)  # it waits long for a page
        assert program.stderr is not None and program.stdout is not None
        address = program.stderr.readline().split()[-1]
        page = browser.new_page()
        page.goto(address)
        page.get_by_role("button", name="Play and record").click()
        expect(page.locator("#state")).to_have_text("Done. The terminal has the same figures.", timeout=LONG)
        assert "OSQE_D" in page.locator("#figures").inner_text()
        page.close()
        figures = json.loads(program.stdout.read())
        program.wait(10.0)
    assert program.returncode == 0
    assert {path.name for path in out.iterdir()} >= {"orig.wav", "rev.wav", "stt.txt", "rev_stt.txt"}
    assert figures["words"] == 4
    assert figures["erroneous_words_person"] <= 1 and figures["erroneous_words_robot"] <= 2
    assert figures["audio"]["estoi"] > 0.5
