"""The common settings: one line of the file changes, what is live holds at once, what is refused says why."""

from pathlib import Path
from typing import Any

import pytest

from console.control.settings_in_use import SettingsInUse, common, with_value
from console.data_folder import SETTINGS_FILE
from console.options import Options, settings_file
from console.speech.robot_voice import RobotVoice
from core.errors import BadInput
from core.pilot.pilot import live as holding_at_once
from core.setting import declared_settings
from core.settings import Settings, read, section_kinds
from tests.console.live import Live

FILE = """\
# my robot
[voice]
speed = 120  # slower
[steering]
# lookahead = 0.3
lookahead = 0.25
"""


def ask(live: Live, path: str, value: Any, token: str = "") -> Any:
    return live.ask("PUT", f"/api/settings/{path}", {"value": value}, token=token or live.operator)


def test_one_line_changes_and_everything_else_stays() -> None:
    assert with_value(FILE, "voice", "speed", 130) == FILE.replace("120", "130")
    assert with_value(FILE, "voice", "pitch", 40) == FILE.replace("[voice]\n", "[voice]\npitch = 40\n")
    assert with_value(FILE, "steering", "lookahead", None) == FILE.replace("lookahead = 0.25\n", "")
    assert with_value(FILE, "limits", "max_speed", 0.2) == FILE + "\n[limits]\nmax_speed = 0.2\n"
    assert with_value("", "people", "engine", "auto") == '[people]\nengine = "auto"\n'
    assert with_value("[company]\nkeep = 1.0\n", "person_following", "keep", 1.2) == "[company]\nkeep = 1.2\n"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("voice = { speed = 120 }\n", "by hand"),
        ("voice.speed = 120\n", "by hand"),
        ("[voice]\nspeed = 100000\n", "must lie between"),
        ("[voice\n", "not valid TOML"),
    ],
)
def test_a_file_of_another_kind_stays_as_it_is(text: str, why: str) -> None:
    with pytest.raises(BadInput, match=why):
        with_value(text, "voice", "pitch", 40)


def test_there_are_some_thirty_common_settings_without_free_texts_or_paths() -> None:
    found = [one for section in section_kinds() for one in common(section)]
    assert 25 <= len(found) <= 40
    assert all(one.meta.meaning for one in found)
    assert all(one.choices or one.kind is not str for one in found)


def test_every_section_that_is_live_is_taken_by_the_pilot_or_is_the_voice() -> None:
    for section, kind in section_kinds().items():
        if not any(one.meta.live for one in declared_settings(kind)) or section == "voice":
            continue
        wanted = read(f"[{section}]\n{_other(section)}\n")
        assert getattr(holding_at_once(Settings(), wanted), section) == getattr(wanted, section), section


def _other(section: str) -> str:
    """A value of a live setting of this section that is not its default."""
    one = next(one for one in common(section) if one.meta.live and one.kind is float)
    return f"{one.name} = {(one.default + one.meta.high) / 2}"


def test_a_live_setting_holds_at_once_and_another_from_the_next_start_on(live: Live) -> None:
    runtime, file = live.runtime, Path(live.runtime.parts[SettingsInUse].state.file)
    assert file.name == SETTINGS_FILE
    changed = ask(live, "voice/speed", 123)
    assert changed.status == 200 and changed.json["sentence"] == "[voice] speed is 123 words/min now."
    assert runtime.parts[RobotVoice].settings.speed == 123
    assert ask(live, "person_following/keep", 1.5).json["setting"]["value"] == 1.5
    live.until(lambda: runtime.pilots.thread.pilot._settings.person_following.keep == 1.5)
    later = ask(live, "limits/max_speed", 0.2).json
    assert "from the next start of the console on" in later["sentence"]
    assert (later["setting"]["value"], later["setting"]["saved"]) == (0.3, 0.2)
    assert live.ask("GET", "/api/settings", token=live.viewer).json["restart"] is True
    assert read(file.read_text()).limits.max_speed == 0.2
    for path in ("voice/speed", "person_following/keep", "limits/max_speed"):
        assert ask(live, path, None).status == 200
    state = live.ask("GET", "/api/settings", token=live.viewer).json
    assert state["restart"] is False and all(one["value"] == one["default"] for one in state["settings"])


def test_what_is_refused_gets_the_sentence_of_the_declaration(live: Live) -> None:
    refused = ask(live, "limits/max_speed", 7)
    assert refused.status == 422
    assert refused.json["detail"] == "max_speed must lie between 0.01 and 1 m/s, not 7."
    assert "must be one of" in ask(live, "voice/voice", "klingon").json["detail"]
    assert ask(live, "voice/speed", "fast").status == 422
    assert ask(live, "limits/margin", 0.01).status == 404 and ask(live, "speech/model", "/etc").status == 404
    assert ask(live, "voice/speed", 100, token=live.viewer).status == 403


def test_the_file_of_the_data_folder_is_read_unless_another_is_named(tmp_path: Path) -> None:
    assert settings_file(Options(), tmp_path) is None
    (tmp_path / SETTINGS_FILE).write_text("[limits]\nmax_speed = 0.2\n")
    assert settings_file(Options(), tmp_path) == tmp_path / SETTINGS_FILE
    assert settings_file(Options(settings=Path("own.toml")), tmp_path) == Path("own.toml")
