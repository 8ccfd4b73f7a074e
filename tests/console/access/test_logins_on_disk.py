"""Keys and logins that outlive the console, and what the command line changes beside it."""

import asyncio
import json
import os
import stat
import time
from pathlib import Path

import pytest

from console.__main__ import main
from console.access.guard import Access
from console.access.login_keeper import LoginKeeper
from console.access.logins import LINK_LIFE_S, LOGIN_LIFE_S, Logins, Person, key_for
from console.access.records import AccessFile
from console.access.token_file import read_token
from console.data_folder import locked
from console.listening import operator_key
from console.options import Options
from core.errors import BadInput


def started(home: Path, ahead: float = 0.0) -> Logins:
    """Logins as a console finds them when it starts."""
    logins = Logins(AccessFile(home), ahead)
    assert logins.open_file() == ""
    return logins


async def settle(logins: Logins) -> list[Person]:
    """Bring memory and disk together → who was signed out by others."""
    gone: list[Person] = []
    await LoginKeeper(logins, lambda who, _: gone.append(who), print).settle()
    return gone


def synced(logins: Logins) -> list[Person]:
    return asyncio.run(settle(logins))


def test_links_and_logins_outlive_a_restart_and_no_secret_is_on_disk(tmp_path: Path) -> None:
    logins = started(tmp_path, ahead=1e9)
    token = "a-link-" + "x" * 40
    logins.admit(token, "tablet", "viewer", "link", 5.0, end=5.0 + LINK_LIFE_S)
    cookie, person = logins.open(token, "", 6.0) or ("", None)
    assert person is not None and person.name == "tablet"
    synced(logins)
    again = started(tmp_path, ahead=2e9 - 1e9 + 100.0)  # the clock of another start of the machine
    assert again.of_cookie(cookie, 7.0) == person
    assert again.of_cookie(cookie, LOGIN_LIFE_S) is None, "its time goes on while nothing runs"
    assert again.bearer(token, 7.0) is not None and again.bearer(token, LINK_LIFE_S) is None
    kept = (tmp_path / "access.json").read_text()
    assert token not in kept and cookie not in kept
    assert {stat.S_IMODE(os.stat(path).st_mode) for path in tmp_path.iterdir()} == {0o600}


def test_a_key_that_is_revoked_ends_the_logins_it_opened_and_no_other(tmp_path: Path) -> None:
    logins = started(tmp_path)
    one, other = (logins.issue(name, "operator") for name in ("one", "other"))
    mine, theirs = (logins.open(token, "", 0.0) for token in (one, other))
    assert mine is not None and theirs is not None
    (key,) = (key for key in logins.all_keys() if key.name == "one")
    assert mine[1] in logins.revoke_key(key.id)
    assert logins.of_cookie(mine[0], 1.0) is None and logins.bearer(one, 1.0) is None
    assert logins.of_cookie(theirs[0], 1.0) == theirs[1]


def test_a_key_whose_time_is_over_ends_no_login(tmp_path: Path) -> None:
    logins = started(tmp_path)
    token = logins.issue("tablet", "viewer", end=10.0)
    cookie, person = logins.open(token, "", 9.0) or ("", None)
    program = logins.bearer(token, 9.0)
    assert logins.expire(11.0) == [program] and logins.bearer(token, 11.0) is None, "its sockets are closed"
    assert logins.of_cookie(cookie, 11.0) == person
    synced(logins)
    assert started(tmp_path).of_cookie(cookie, 11.0) == person


def test_what_the_command_line_adds_and_revokes_counts_in_the_running_console(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    now = time.time()
    logins = started(tmp_path)
    cookie, _ = logins.open(logins.issue("operator", "operator"), "Ann", now) or ("", None)
    synced(logins)
    data = ["--data", str(tmp_path), "--json"]
    assert main(["token", "add", "vacuum", "--role", "operator", *data]) == 0
    token = json.loads(capsys.readouterr().out)["token"]
    assert logins.bearer(token, now) is None
    assert synced(logins) == []
    program = logins.bearer(token, now)
    assert program is not None and program.name == "vacuum"
    assert main(["token", "add", "Vacuum", "--role", "viewer", *data]) == 1, "names tell keys apart"
    assert main(["token", "revoke", "vacuum", *data]) == 0
    assert main(["token", "revoke", "Ann", *data]) == 0
    assert {one.name for one in synced(logins)} == {"vacuum", "Ann"}
    assert logins.bearer(token, now) is None and logins.of_cookie(cookie, now) is None
    assert main(["token", "revoke", "Ann", *data]) == 1
    capsys.readouterr()
    assert main(["token", "list", *data]) == 0
    assert [key["name"] for key in json.loads(capsys.readouterr().out)["keys"]] == ["operator"]


def test_a_login_that_is_not_on_disk_yet_is_not_lost_to_a_change_by_others(tmp_path: Path) -> None:
    logins = started(tmp_path)
    token = logins.issue("operator", "operator")
    synced(logins)
    cookie, person = logins.open(token, "", 0.0) or ("", None)
    on_disk = AccessFile(tmp_path).change([])
    key_for(tmp_path, "vacuum", "operator", "program", 0.0)
    assert logins.synced(on_disk, 0) == []
    assert logins.of_cookie(cookie, 1.0) == person
    assert synced(logins) == []
    assert len(logins.all_keys()) == 2 and started(tmp_path).of_cookie(cookie, 1.0) == person


def test_a_login_opened_while_its_key_was_revoked_elsewhere_does_not_stay(tmp_path: Path) -> None:
    logins = started(tmp_path)
    token = logins.issue("tablet", "viewer")
    synced(logins)
    cookie, person = logins.open(token, "", 0.0) or ("", None)
    assert main(["token", "revoke", "tablet", "--data", str(tmp_path)]) == 0
    assert person in synced(logins)
    assert logins.of_cookie(cookie, 1.0) is None


@pytest.mark.parametrize("damage", [b"", b"{}", b"[1]", b'{"keys": {}, "logins": {}, "sha256": "0"}', b"\xff" * 9])
def test_a_damaged_file_is_put_aside_and_named(tmp_path: Path, damage: bytes) -> None:
    (tmp_path / "access.json").write_bytes(damage)
    logins = Logins(AccessFile(tmp_path))
    assert "access.json.damaged" in logins.open_file()
    assert (tmp_path / "access.json.damaged").read_bytes() == damage
    logins.issue("operator", "operator")
    synced(logins)
    assert len(started(tmp_path).all_keys()) == 1


def test_a_token_file_is_written_once_and_another_ends_what_it_opened(tmp_path: Path) -> None:
    file, home = tmp_path / "key", tmp_path / "home"
    home.mkdir()
    options = Options(token_file=file)
    logins = started(home)
    token = operator_key(options, Access(logins), 0.0)
    assert file.read_text().strip() == token and file.stat().st_mode & 0o777 == 0o600
    cookie, _ = logins.open(token, "", 0.0) or ("", None)
    synced(logins)
    again = started(home)
    assert operator_key(options, Access(again), 0.0) == token
    assert again.of_cookie(cookie, 1.0) is not None
    file.unlink()
    assert operator_key(options, Access(again), 0.0) != token
    assert again.of_cookie(cookie, 1.0) is None and again.bearer(token, 1.0) is None


@pytest.mark.parametrize(("text", "mode"), [("short", 0o600), ("a b" * 20, 0o600), ("x" * 40, 0o644)])
def test_a_token_file_that_is_weak_or_open_to_others_is_refused(tmp_path: Path, text: str, mode: int) -> None:
    file = tmp_path / "key"
    file.write_text(text)
    file.chmod(mode)
    with pytest.raises(BadInput) as refused:
        read_token(file)
    assert text not in str(refused.value)


def test_a_link_needs_a_running_console(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = ["--data", str(tmp_path), "--json"]
    assert main(["link", *data]) == 1
    assert "beckon run" in capsys.readouterr().err
    with locked(tmp_path) as lock:
        lock.announce(8420, "http://192.168.1.20:8420/")
        assert main(["link", "--role", "viewer", "--name", "tablet", *data]) == 0
    made = json.loads(capsys.readouterr().out)
    base, _, token = made["address"].partition("#t=")
    assert base == "http://192.168.1.20:8420/"
    person = started(tmp_path).bearer(token, time.time())
    assert person is not None and (person.name, person.role) == ("tablet", "viewer")
