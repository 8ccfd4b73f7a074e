"""The addresses to which operators may make the console connect: each way to write one, and what becomes of it."""

import socket
from pathlib import Path
from typing import Any

import pytest

from console.connection import reach
from console.connection.reach import Reach, inside, is_own, masked, read_entry, unmapped
from console.http.problems import Problem
from core.errors import BadInput, BadSettings, BeckonError
from core.robots.ros.socket_link import parse_address

NAMES = {"robot.lan": ["192.168.7.7"], "twice.lan": ["127.0.0.1", "10.1.2.3"], "evil.example": ["169.254.169.254"]}
SCHEMES = ["foxglove://{}:5", "rosbridge://{}:5", "zenoh://{}:5/robot", "serial://{}:5", "srv1://{}:5", "scip://{}:5",
           "lds://{}:5?model=ld19", "camera://http/{}:5/a?b=1", "camera://rtsp/ann:word@{}:5/a"]  # fmt: skip


@pytest.fixture(autouse=True)
def name_service(monkeypatch: pytest.MonkeyPatch) -> None:
    """Names as above; digits as the machine itself reads them; no address is this machine's but the loopback ones."""
    real = socket.getaddrinfo

    def resolved(host: str, port: Any, **more: Any) -> Any:
        found = NAMES.get(host)
        return [(0, 0, 0, "", (one, port)) for one in found] if found else real(host, port, **more)

    monkeypatch.setattr(reach.socket, "getaddrinfo", resolved)
    monkeypatch.setattr(reach, "is_own", lambda address: address.is_loopback or str(address) == "192.168.7.1")


PRIVATE_NETWORKS = ("10.0.0.0/8", "172.16.0.0/12", "192.168.0.0/16", "fc00::/7")


def outcome(rule: Reach, url: str) -> str:
    """Return the URL that is handed on, or the status of the refusal."""
    try:
        return rule.pinned(url)
    except Problem as refused:
        return str(refused.status)
    except BeckonError as error:
        return type(error).__name__


@pytest.mark.parametrize("url", SCHEMES)
def test_every_kind_of_link_reaches_the_networks_that_were_named_by_their_digits_and_nothing_else(url: str) -> None:
    rule = Reach(PRIVATE_NETWORKS)
    for host, address in {"10.1.2.3": "10.1.2.3", "robot.lan": "192.168.7.7", "[fd00::7]": "[fd00::7]"}.items():
        assert rule.pinned(url.format(host)) == url.format(address)
    assert rule.pinned(url.format("twice.lan")) == url.format("10.1.2.3"), "the address that was checked is used"
    refused = ["127.0.0.1", "127.1", "2130706433", "0x7f000001", "0.0.0.0", "localhost", "[::1]",
               "[::ffff:127.0.0.1]", "169.254.169.254", "[fe80::1]", "224.0.0.1", "8.8.8.8",
               "evil.example", "192.168.7.1"]  # fmt: skip
    assert {host: outcome(rule, url.format(host)) for host in refused} == dict.fromkeys(refused, "403")


def test_the_certificate_of_an_encrypted_link_is_still_that_of_the_name() -> None:
    rule, pinned = Reach(PRIVATE_NETWORKS), "192.168.7.7:5?tls=1"
    for kind in ("foxglove", "rosbridge"):
        assert rule.pinned(f"{kind}://robot.lan:5?tls=1") == f"{kind}://{pinned}&tls_name=robot.lan"
        assert parse_address(f"//{pinned}&tls_name=robot.lan", 1).certified_name == "robot.lan:5"
        for unchanged in (
            "10.1.2.3:5?tls=1",
            "10.1.2.3:5?tls=1&tls_name=a.lan",
            "[fd00::7]:5?tls=1",
            "10.1.2.3?tls=0",
        ):
            assert rule.pinned(f"{kind}://{unchanged}") == f"{kind}://{unchanged}"
        assert "tls_name" not in rule.pinned(f"{kind}://robot.lan:5?scan=/scan")
        assert rule.pinned(f"{kind}://robot.lan?tls=1&tls_name=b").endswith("7.7?tls=1&tls_name=b")


@pytest.mark.parametrize(
    "url",
    [
        "camera:///etc/passwd",
        "camera://0",
        "camera://https/10.1.2.3/a",
        "camera://file/10.1.2.3/a",
        "audio:///talk.wav",
        "audio://ReSpeaker",
        "serial:///dev/ttyUSB0",
        "serial://com3",
        "lds:///dev/ttyUSB1?model=ld19",
        "foxglove://10.1.2.3:5?array=/etc/array.toml",
        "zenoh://10.1.2.3:5?tls=1&ca=/etc/passwd",
        "foxglove://10.1.2.3:5+serial:///dev/ttyUSB0",
        "foxglove://10.1.2.3:5+foxglove://127.0.0.1:5",
        "foxglove://10.1.2.3\\@127.0.0.1:5",
        "foxglove://10.1.2.3#@127.0.0.1:5",
        "camera://http/a@127.0.0.1:5/10.1.2.3",
        "foxglove:10.1.2.3",
        "foxglove://",
    ],
)
def test_files_devices_and_addresses_in_disguise_are_the_administrators(url: str) -> None:
    assert outcome(Reach(["10.0.0.0/8"]), url) == "403"


def test_what_the_start_names_is_reached_and_nothing_else() -> None:
    rule = Reach(["127.0.0.1:9", "robot.lan", "[::1]:7", "192.168.7.0/24", "/srv/recordings"])
    reached = ["127.0.0.1:9", "robot.lan:1", "[::1]:7", "192.168.7.8"]
    refused = ["127.0.0.1:8", "127.0.0.1", "[::1]:8", "10.1.2.3", "192.168.7.1"]
    answers = {host: outcome(rule, f"foxglove://{host}") for host in reached + refused}
    assert [host for host in answers if answers[host] == "403"] == refused
    assert inside(Path("/srv/recordings/a.mcap"), rule.folders) and not inside(Path("/srv/a.mcap"), rule.folders)
    with pytest.raises(BadInput):
        inside(Path("/srv/recordings/../a.mcap"), rule.folders)
    for start in ([], ["/srv"]):
        assert outcome(Reach(start), "foxglove://10.1.2.3") == "403", "only the administrator connects robots"
    for wrong in ("", "10.0.0.0/99", "http://a", "a b", "robot:port"):
        with pytest.raises(BadSettings, match="--connect takes"):
            read_entry(wrong)


def test_passwords_are_not_written_down_and_all_else_is() -> None:
    assert masked("camera://rtsp/ann:word@10.0.0.1/a?reboot=1") == "camera://rtsp/ann:***@10.0.0.1/a?reboot=1"
    assert masked("camera://http/10.0.0.1/a?user=ann&Password=word&b=1") == (
        "camera://http/10.0.0.1/a?user=ann&Password=***&b=1"
    )
    assert masked("foxglove://:word@10.0.0.1:5") == "foxglove://:***@10.0.0.1:5"
    assert masked("foxglove://10.0.0.1:5?scan=/scan") == "foxglove://10.0.0.1:5?scan=/scan"


def test_this_computers_own_addresses_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    assert is_own(unmapped("127.0.0.1")) and not is_own(unmapped("192.0.2.1"))
