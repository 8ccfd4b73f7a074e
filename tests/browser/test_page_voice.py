"""Speaking to the robot: a browser with a recording instead of a microphone."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from core.message import Array
from core.recording.sound_file import read_sound, write_wav
from core.sensors.microphones import Sound
from core.speech.recognition.recognizer import at_16_khz
from tests.browser.running_console import Running
from tests.browser.visit import FLAT, Visit

Open = Callable[..., Visit]
RATE = 16_000
LONG = 240_000  # [ms] on a busy machine words come too late, and the clip is said again
PROSE = 4.0  # [s]

GIVE_BACK = """async () => {
  const headers = { "content-type": "application/json" };
  await fetch("api/stop", { method: "POST", headers });
  await fetch("api/lease", { method: "POST", headers, body: JSON.stringify({ do: "release" }) });
}"""


CANCEL_THE_FIRST = """() => {
  window.seen = { cards: [], box: [] };
  const card = document.querySelector("pending-command-card");
  new MutationObserver(() => {
    if (card.hidden || card.dataset.state === "begun" || seen.cards.length) return;
    seen.cards.push(card.innerText);
    card.querySelector("[aria-label^=Cancel]").click();
  }).observe(card, { attributes: true, childList: true, characterData: true, subtree: true });
  setInterval(() => seen.box.push(document.querySelector("#words").value), 100);
}"""


def said(shared: Path, *names: str) -> Array:
    """Recordings one after another, with pauses."""
    quiet = 2e-4 * np.random.default_rng(0).normal(size=2 * RATE)
    parts = [quiet] * 5  # while the browser and the console make ready
    for name in names:
        samples = at_16_khz(read_sound(shared / name)).samples[:, 0]
        parts += [samples[: round(PROSE * RATE)] * 0.5 / np.abs(samples).max(), quiet]
    return np.concatenate(parts)


@pytest.fixture(scope="module")
def chromium_flags(tmp_path_factory: pytest.TempPathFactory, shared_data: Path) -> list[str]:
    spoken = said(
        shared_data,
        "speech_commands_tts/flite_slt_09.flac",
        "speech_commands_tts/flite_slt_09.flac",  # again, as one would: a busy machine loses some sound
        "speech_commands_tts/flite_slt_02.flac",
        "speech_real/librivox_0870.flac",
        *("speech_commands_tts/flite_slt_01.flac",) * 2,
    )
    file = tmp_path_factory.mktemp("voice") / "voice.wav"
    write_wav(file, Sound(stamp=0.0, rate=RATE, samples=np.concatenate((spoken, np.zeros(300 * RATE)))[:, None]))
    return [
        *FLAT,
        "--use-fake-device-for-media-stream",
        "--use-fake-ui-for-media-stream",
        f"--use-file-for-fake-audio-capture={file}%noloop",
    ]


@pytest.mark.campaign
@pytest.mark.real_data
def test_what_is_said_into_the_browser_is_obeyed_or_refused_in_words(visit: Open, console: Running) -> None:
    here = visit()
    before = [row["id"] for row in console.ask("api/commands/history")["commands"]]
    here.page.evaluate(CANCEL_THE_FIRST)
    here.page.get_by_role("button", name="Microphone", exact=True).click()
    here.page.get_by_label("Leave it open").check(force=True)
    accepted = here.find("hearing-card .transcript[data-state=accepted]")
    for words in ("continue 2.5 meters", "stop moving", "turn right"):
        expect(accepted.filter(has_text=words).first).to_be_attached(timeout=LONG)
    rows = [row for row in console.ask("api/commands/history")["commands"] if row["id"] not in before]
    names = [row["name"] for row in reversed(rows) if row["state"] != "refused" and row["source"] == "voice"]
    assert [name for at, name in enumerate(names) if names[at - 1 : at] != [name]] == [
        "continue",
        "stop_moving",
        "turn_right",
    ]
    assert any(row["state"] == "refused" and row["source"] == "voice" for row in rows)
    seen = here.page.evaluate("seen")
    assert "Continue 2.50 m" in seen["cards"][0] and "begins in" in seen["cards"][0]
    assert "continue 2.5 meters" in seen["box"]
    dropped = [row for row in rows if row["state"] == "cancelled" and "It had not begun" in row["remark"]]
    assert any("Dropped by" in row["remark"] for row in dropped), rows
    here.page.get_by_label("Leave it open").uncheck(force=True)
    here.page.evaluate(GIVE_BACK)
    assert here.complaints == []
