"""Robots on the fleet's bus: certificates, presence, STOP ALL, and a fleet that is lost."""

import asyncio
import contextlib
import os
import shutil
import ssl
import subprocess
import threading
from collections.abc import Awaitable, Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

import console.fleet.authority as authority_module
from console.fleet.authority import Authority, CertificateFiles
from console.fleet.bus import (
    FleetAddress,
    FleetStopAnswer,
    FleetStopRequest,
    RobotReport,
    check_handshake,
    client_settings,
    key_of,
    open_session,
    trusting,
)
from console.fleet.router import HALT_FILE, FleetRouter, FleetStop, _held_halt
from core.errors import BadInput, BeckonError
from core.files import write_atomic
from core.robots.ros.zenoh_session import load_zenoh
from tests.emulators.light_console import LightConsole
from tests.emulators.zenoh_robot import free_port

pytestmark = pytest.mark.skipif(
    shutil.which("openssl") is None, reason="a certificate needs openssl: apt install openssl"
)

ROBOTS = ("r1", "r2", "r3")
FORGED = msgspec.json.encode(
    RobotReport(address="forged", robot="r", simulated=True, robot_link="live", robot_age_s=0.1)
)


class Site:
    """The certificates of a fleet, which all tests share: each takes a fifth of a second."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.authority = folder, Authority(folder / "fleet")
        self.authority.prepare(("127.0.0.1",))
        for name in ROBOTS:
            self.authority.issue(name, folder / name, kind="robot")
        self.authority.issue("watcher", folder / "watcher", kind="viewer")

    @asynccontextmanager
    async def running(self, *robots: str) -> Any:
        """The router and the consoles of these robots, all live."""
        address = FleetAddress("127.0.0.1", free_port())
        router = FleetRouter(self.authority, address)
        await router.open()
        work = asyncio.create_task(router.run())
        consoles = [LightConsole(name, address, self.folder / name, self.folder / f"{name}-home") for name in robots]
        for console in consoles:
            console.open()
        try:
            await until(lambda: all(router.table.robots[name].link == "live" for name in robots))
            yield router, address, consoles
        finally:
            for console in consoles:
                await console.close()
            work.cancel()
            await router.close()

    def files(self, name: str) -> CertificateFiles:
        return CertificateFiles(self.folder / name)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    site = Site(tmp_path_factory.mktemp("site"))
    yield site
    (site.authority.folder / "halt.json").unlink(missing_ok=True)


async def until(true: Callable[[], Any], seconds: float = 20.0) -> Any:
    async with asyncio.timeout(seconds):
        while not (value := true()):
            await asyncio.sleep(0.01)
        return value


def run(work: Awaitable[None]) -> None:
    async def whole() -> None:
        await work

    asyncio.run(whole())


def said(sample: Any) -> tuple[str, bytes]:
    return str(sample.key_expr), sample.payload.to_bytes()


def test_a_certificate_says_under_its_own_name_alone_and_a_viewer_says_nothing(site: Site) -> None:
    async def work() -> None:
        async with site.running("r1") as (router, address, _):
            heard: list[tuple[str, bytes]] = []  # by the router: what a session says, it also hears itself
            seen: list[str] = []
            forged: list[str] = []
            kept = [router._session.declare_subscriber("beckon/**", lambda one: heard.append(said(one)))]
            sessions = {
                name: await asyncio.to_thread(open_session, client_settings(address, site.files(name)), "refused")
                for name in ("r2", "watcher")
            }
            robot, watcher = sessions["r2"], sessions["watcher"]
            kept.append(watcher.declare_subscriber(key_of("r1", "state"), lambda one: seen.append(said(one)[0])))
            kept.append(robot.declare_subscriber(key_of("r1", "state"), lambda one: forged.append("heard")))
            kept.append(robot.declare_queryable(key_of("r3", "stop"), lambda _: forged.append("asked")))
            for session in sessions.values():
                for name in ("r2", "r3"):
                    session.put(key_of(name, "state"), str(session.zid()).encode())
                    kept.append(session.liveliness().declare_token(key_of(name, "alive")))
            await until(lambda: router.table.robots["r2"].alive and seen)
            replies = await asyncio.to_thread(
                lambda: [
                    reply.ok
                    for one in sessions.values()
                    for reply in one.get(key_of("r1", "stop"), payload=b"{}", timeout=0.2)
                ]
            )
            stop = await router.stop_all("stop", "test")
            assert not any(replies) and forged == [] and set(seen) == {key_of("r1", "state")}
            assert [key for key, by in heard if by == str(robot.zid()).encode()] == [key_of("r2", "state")]
            assert [key for key, by in heard if by == str(watcher.zid()).encode()] == []
            assert not router.table.robots["r3"].alive
            assert [name for name, one in stop.robots.items() if one.acknowledged] == ["r1"]
            del kept
            for one in sessions.values():
                await asyncio.to_thread(one.close)

    run(work())


def test_a_certificate_that_does_not_fit_is_refused_with_a_sentence_that_says_why(
    site: Site, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("console.fleet.bus.REFUSAL_TIMEOUT_S", 20.0)  # on a busy machine; none is waited for in vain
    other = Authority(tmp_path / "other")
    other.issue("r1", tmp_path / "stranger", kind="robot")
    Authority(site.authority.folder)._sign("r1", "DNS:r1", site.files("old"), -1)
    empty = tmp_path / "nothing"
    mixed = tmp_path / "mixed"  # their authority, another's certificate
    shutil.copytree(tmp_path / "stranger", mixed)
    shutil.copy(site.files("r1").authority, mixed / "authority.pem")

    def refused(address: FleetAddress, files: CertificateFiles) -> str:
        with pytest.raises(BeckonError) as why:
            check_handshake(address, files)
        return str(why.value)

    async def work() -> None:
        async with site.running() as (_, address, _consoles):
            rows = [
                (address, CertificateFiles(tmp_path / "stranger"), "another authority"),
                (address, CertificateFiles(mixed), "does not take this robot's certificate"),
                (address, site.files("old"), "has expired"),
                (address, CertificateFiles(empty), "is not there"),
                (FleetAddress("127.0.0.1", free_port()), site.files("r1"), "No fleet answers"),
            ]
            for where, files, says in rows:
                assert says in await asyncio.to_thread(refused, where, files), says
            monkeypatch.undo()
            await asyncio.to_thread(check_handshake, address, site.files("r1"))
            router = FleetRouter(site.authority, FleetAddress("127.0.0.2", free_port()))
            await router.open()
            elsewhere = router._listen
            assert "does not bear the name" in await asyncio.to_thread(refused, elsewhere, site.files("r1"))
            await router.close()

    run(work())


def shake_hands(shown: CertificateFiles, named: str) -> None:
    """TLS without a network, between a console and a fleet. Raises ssl.SSLError, ValueError."""
    server = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    server.load_cert_chain(shown.certificate, shown.key)
    up, down = ssl.MemoryBIO(), ssl.MemoryBIO()
    sides = [trusting(named).wrap_bio(down, up), server.wrap_bio(up, down, server_side=True)]
    for side in 3 * sides:
        with contextlib.suppress(ssl.SSLWantReadError):
            side.do_handshake()
    assert sides[0].version() is not None


def test_a_console_is_known_by_the_one_certificate_that_was_named_whoever_else_the_authority_has_signed(
    site: Site,
) -> None:
    Authority(site.authority.folder)._sign("r1", "DNS:r1", site.files("again"), 100)
    Authority(site.authority.folder)._sign("r1", "DNS:r1", site.files("old"), -1)
    named = {name: site.files(name).certificate.read_text() for name in ("r1", "r2", "again", "old")}
    shake_hands(site.files("r1"), named["r1"])
    rows = [
        ("r2", named["r1"], "certificate"),  # another robot of the same fleet
        ("again", named["r1"], "certificate"),  # of the same name, by another key
        ("old", named["old"], "expired"),
        ("r1", "", "."),
        ("r1", "no certificate", "."),
    ]
    for shown, told, says in rows:
        with pytest.raises((ssl.SSLError, ValueError), match=says):
            shake_hands(site.files(shown), told)


@pytest.mark.parametrize("text", ["tcp/host:7447", "tls/host:0", "tls/", "tls/a b", "host", "tls/host:99999"])
def test_an_address_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(BadInput, match="tls/HOST:7447"):
        FleetAddress.parse(text)


@pytest.mark.parametrize("name", ["", "fleet", "a/b", "*", "r 1", "-r", "x" * 41, "ü"])
def test_a_name_that_could_be_another_key_gets_no_certificate(site: Site, name: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="no name of a robot"):
        site.authority.issue(name, tmp_path, kind="robot")


def test_stop_all_names_who_has_not_answered_and_a_halt_takes_who_comes_later(site: Site) -> None:
    async def work() -> None:
        async with site.running("r1", "r2") as (router, address, (first, second)):
            first.robot.drive()
            second.robot.drive()
            await until(lambda: first.robot.status().v > 0 and second.robot.status().v > 0)
            second.robot.frozen = second.robot.status()  # its gate does not obey, so nothing is acknowledged
            stop = await router.stop_all("stop", "Ann")
            assert stop.robots["r1"].acknowledged and stop.robots["r1"].ms is not None
            assert first.robot.status().v == 0
            assert not stop.robots["r2"].acknowledged and router.table.robots["r2"].need == "unanswered"
            assert not stop.all and not stop.robots["r3"].acknowledged
            second.robot.frozen = None
            await until(lambda: stop.robots["r2"].acknowledged)  # it was asked again
            assert second.robot.status().v == 0 and not router.table.robots["r2"].unanswered
            assert (await router.stop_all("halt", "Ann")).robots["r1"].acknowledged
            third = LightConsole("r3", address, site.folder / "r3", site.folder / "r3-home")
            third.open()
            await until(lambda: third.robot.status().state == "halted")
            await router.reset_halt()
            assert {one.robot.status().state for one in (first, second, third)} == {"halted"}
            third.robot.reset()
            await asyncio.sleep(1.2)  # longer than it takes to ask again: nobody is halted any more
            assert third.robot.status().state != "halted"
            await third.close()

    run(work())


def test_a_stop_is_repeated_while_an_older_halt_waits_for_another_robot(site: Site) -> None:
    async def work() -> None:
        async with site.running("r1") as (router, address, (first,)):
            assert (await router.stop_all("halt", "Ann")).robots["r1"].acknowledged
            await until(lambda: first.robot.status().state == "halted")
            first.robot.reset()
            first.robot.drive()
            await until(lambda: first.robot.status().v > 0)
            first.robot.frozen = first.robot.status()
            stop = await router.stop_all("stop", "Bob")
            assert not stop.robots["r1"].acknowledged
            asked = stop.robots["r1"].asked_at
            await until(lambda: stop.robots["r1"].asked_at > asked)  # the halt of r2 and r3 has had its turn, too
            assert router.stop is stop
            first.robot.frozen = None
            await until(lambda: stop.robots["r1"].acknowledged)
            assert first.robot.status().v == 0
            second = LightConsole("r2", address, site.folder / "r2", site.folder / "r2-home")
            second.open()
            await until(lambda: second.robot.status().state == "halted")
            assert first.robot.status().state != "halted" and router.stop is stop
            await router.reset_halt()
            await second.close()

    run(work())


class RouterAlone:
    """A router that listens nowhere, and one robot that it knows."""

    def __init__(self, folder: Path) -> None:
        self.router = FleetRouter(Authority(folder), FleetAddress("127.0.0.1", 1))
        self.router.table.know(["r1"], 0.0)
        self.robot = self.router.table.robots["r1"]
        self.robot.report = msgspec.json.decode(FORGED, type=RobotReport)

    def answer(self, stop: FleetStop) -> None:
        self.router._answered(stop, "r1", FleetStopAnswer(stands=True, state="halted"), stop.began)


def test_a_late_answer_to_an_older_halt_is_none_to_a_newer_one(tmp_path: Path) -> None:
    async def work() -> None:
        fleet = RouterAlone(tmp_path)
        router = fleet.router
        older = await router.stop_all("halt", "Ann")
        await router.reset_halt()
        newer = await router.stop_all("halt", "Bob")
        fleet.answer(older)
        assert fleet.robot.unanswered and router.halt is not None and router.halt.acknowledged == []
        fleet.answer(newer)
        assert not fleet.robot.unanswered and router.halt.acknowledged == ["r1"]

    run(work())


def test_a_halt_that_is_reset_while_it_is_written_is_not_on_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, go_on, done = threading.Event(), threading.Event(), threading.Event()

    def slowly(path: Path, content: bytes) -> None:
        begun.set()
        assert go_on.wait(10)
        write_atomic(path, content)
        done.set()

    async def work() -> None:
        fleet = RouterAlone(tmp_path)
        stop = await fleet.router.stop_all("halt", "Ann")
        assert (tmp_path / HALT_FILE).is_file()
        monkeypatch.setattr("console.fleet.router.write_atomic", slowly)
        fleet.answer(stop)
        await until(begun.is_set)
        resetting = asyncio.create_task(fleet.router.reset_halt())
        await asyncio.sleep(0.05)
        go_on.set()
        await resetting
        await until(done.is_set)
        assert not (tmp_path / HALT_FILE).exists()

    run(work())


def test_stops_are_repeated_while_the_list_of_certificates_cannot_be_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unread(_: Authority) -> float:
        raise PermissionError(13, "Permission denied")

    async def work() -> None:
        router = RouterAlone(tmp_path).router
        router._known = router._authority.changed
        repeated: list[float] = []
        monkeypatch.setattr(router, "_repeat", repeated.append)
        with monkeypatch.context() as patch:
            patch.setattr(Authority, "changed", property(unread))
            running = asyncio.create_task(router.run())
            await until(lambda: len(repeated) > 1)
            assert "Permission denied" in router.trouble
        await until(lambda: not router.trouble)
        running.cancel()

    run(work())


@pytest.mark.parametrize(("content", "halts"), [(None, False), (b"{", True)])
def test_a_halt_that_cannot_be_read_is_a_halt(tmp_path: Path, content: bytes | None, halts: bool) -> None:
    if content is not None:
        (tmp_path / HALT_FILE).write_bytes(content)
    assert (_held_halt(tmp_path / HALT_FILE) is not None) is halts


def test_a_list_that_cannot_be_looked_at_is_said_and_ends_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    readable = threading.Event()

    def changed(_: Authority) -> float:
        if not readable.is_set():
            raise PermissionError(13, "Permission denied")
        return 0.0

    async def work() -> None:
        router = RouterAlone(tmp_path).router
        router._known = 0.0
        monkeypatch.setattr(Authority, "changed", property(changed))
        running = asyncio.create_task(router.run())
        await until(lambda: "Permission denied" in router.trouble)
        readable.set()
        await until(lambda: router.trouble == "")
        assert not running.done()
        running.cancel()

    run(work())


def test_a_halt_that_is_written_after_all_is_no_trouble_any_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    async def work() -> None:
        router = RouterAlone(tmp_path).router
        with monkeypatch.context() as disk:
            disk.setattr("console.fleet.router.write_atomic", fail)
            await router.stop_all("halt", "Ann")
        assert "No space left" in router.trouble
        await router.stop_all("halt", "Ann")
        assert router.trouble == ""

    run(work())


def test_a_session_that_is_closed_says_of_no_robot_that_it_has_gone(site: Site) -> None:
    async def work() -> None:
        async with site.running("r1") as (router, _, _):
            former = router._session
            await router._restart()
            await until(lambda: router.table.robots["r1"].link == "live")
            gone: Any = SimpleNamespace(kind=load_zenoh().SampleKind.DELETE, key_expr=key_of("r1", "alive"))
            router._token_changed(former, gone)
            await asyncio.sleep(0.05)
            assert router.table.robots["r1"].alive
            router._session.close()
            assert await router.picture("r1") is None

    run(work())


def test_a_stop_that_has_come_holds_although_the_fleet_is_lost_before_it_is_answered(site: Site) -> None:
    def reply(*_: object) -> None:
        raise load_zenoh().ZError("the session is closed")

    async def work() -> None:
        async with site.running("r1") as (_, _, (console,)):
            console.member._session = None
            request = msgspec.json.encode(FleetStopRequest("halt", "Ann"))
            payload, dropped = SimpleNamespace(to_bytes=lambda: request), threading.Event()
            asked = SimpleNamespace(payload=payload, reply=reply, drop=dropped.set)
            await asyncio.to_thread(console.member.asked_to_stand, asked)
            await until(lambda: console.robot.status().state == "halted")
            await until(dropped.is_set)

    run(work())


def test_the_loss_of_the_fleet_changes_nothing_at_a_robot_but_is_said_and_it_joins_again(site: Site) -> None:
    async def work() -> None:
        async with site.running(*ROBOTS) as (router, _, consoles):
            console = consoles[0]
            for one in consoles:
                one.robot.drive()

            def drive() -> bool:
                return all(one.robot.status().v > 0 for one in consoles)

            await until(drive)
            await router.close()
            await until(lambda: all("nothing changes" in one.notifications.shown[-1].text for one in consoles))
            assert drive()
            await router._restart()
            assert {router.table.robots[name].link for name in ROBOTS} <= {"stale", "live"}
            await until(lambda: all(router.table.robots[name].link == "live" for name in ROBOTS))
            assert drive()
            await until(lambda: [one.text[:6] for one in console.notifications.shown] == ["Joined"])
            assert len(await router.picture("r1") or b"") > 1000
            assert await router.picture("r9") is None
            key = await router.console_key("r1", "Ann", "operator")
            person = console.logins.bearer(key.token if key else "", 1.0)
            assert person is not None and (person.name, person.role) == ("Ann", "operator")

    run(work())


def test_a_new_certificate_is_let_in_and_a_withdrawn_or_older_one_is_nobody_while_the_fleet_runs(site: Site) -> None:
    async def work() -> None:
        async with site.running("r1") as (router, address, _):
            robots = {
                name: LightConsole("r9", address, site.folder / name, site.folder / "home") for name in ("r9", "new")
            }
            site.authority.issue("r9", site.folder / "r9", kind="robot")
            site.authority.issue("reader", site.folder / "reader", kind="viewer")
            await taken_in(site, router)
            robots["r9"].open()
            await until(lambda: router.table.robots["r9"].link == "live")
            reader = await asyncio.to_thread(open_session, client_settings(address, site.files("reader")), "refused")
            heard: list[str] = []
            kept = listening(reader, heard)
            await until(lambda: {key_of("r1", "state"), key_of("r1", "alive")} <= set(heard))
            await asyncio.to_thread(reader.close)
            for name in ("r9", "reader"):
                site.authority.withdraw(name)
            await taken_in(site, router)
            await are_nobody(router, address, site.files("r9"), site.files("reader"))
            for name in ("older", "new"):
                site.authority.issue("r9", site.folder / name, kind="robot")
            await taken_in(site, router)
            await are_nobody(router, address, site.files("r9"), site.files("older"))
            said_last = robots["r9"].notifications.shown
            await until(lambda: any("does not take this robot's certificate" in one.text for one in said_last), 60)
            assert router.table.robots["r9"].report is None
            robots["new"].open()
            await until(lambda: router.table.robots["r9"].link == "live")
            site.authority.withdraw("r9")
            for robot in robots.values():
                await robot.close()
            del kept

    run(work())


async def taken_in(site: Site, router: FleetRouter) -> None:
    """Until the router goes by the list of certificates as it is now, and its robot is back."""
    await until(lambda: router._known == site.authority.changed and router.table.robots["r1"].link == "live")


async def are_nobody(router: FleetRouter, address: FleetAddress, *certificates: CertificateFiles) -> None:
    """Whoever has one of these is not shown as r9, hears nothing of others, and is neither asked nor answered.

    A session that is let in nowhere still hears what it says itself: what counts is what the router hears.
    """
    heard, reached, asked = list[str](), list[bytes](), list[str]()
    settings = [client_settings(address, files) for files in certificates]
    sessions = [await asyncio.to_thread(open_session, each, "refused") for each in settings]
    kept = [router._session.declare_subscriber("**", lambda one: reached.append(said(one)[1]))]
    for session in sessions:
        kept += listening(session, heard)
        kept.append(session.declare_queryable(key_of("r9", "stop"), lambda _: asked.append("stop")))
        kept.append(session.liveliness().declare_token(key_of("r9", "alive")))
        session.put(key_of("r1", "state"), FORGED)
        session.put(key_of("r9", "state"), FORGED)
    at = router.table.robots["r1"].heard_at
    await until(lambda: router.table.robots["r1"].heard_at > at + 1.0)
    await router.stop_all("stop", "test")
    assert not asked
    answers = await asyncio.to_thread(
        lambda: [
            reply.ok
            for session in sessions
            for found in (session.get("**", timeout=0.2), session.liveliness().get("**", timeout=0.2))
            for reply in found
            if reply.ok is None or "r9" not in str(reply.ok.key_expr)
        ]
    )
    row = router.table.robots.get("r9")
    assert (row is None or row.link == "gone") and set(heard) <= {key_of("r9", "alive")}
    assert FORGED not in reached and not any(answers)
    del kept
    for session in sessions:
        await asyncio.to_thread(session.close)


def listening(session: Any, heard: list[str]) -> list[Any]:
    """Write down the keys of all that a session can read, but the state that it says itself."""

    def hear(sample: Any) -> None:
        if sample.payload.to_bytes() != FORGED:
            heard.append(str(sample.key_expr))

    return [
        session.declare_subscriber("**", hear),
        session.declare_subscriber(key_of("*", "state"), hear),
        session.liveliness().declare_subscriber(key_of("*", "alive"), hear, history=True),
    ]


def test_an_authority_that_was_made_anew_makes_its_routers_certificate_anew(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    authority.prepare(("127.0.0.1",))
    kept, robot = authority.router.certificate.read_bytes(), CertificateFiles(tmp_path / "r1")
    authority.prepare(("127.0.0.1",))
    assert authority.router.certificate.read_bytes() == kept
    shutil.rmtree(tmp_path / "authority")
    authority.issue("r1", robot.folder, kind="robot")
    authority.prepare(("127.0.0.1",))
    assert authority.router.authority.read_bytes() == robot.authority.read_bytes()
    check = ["openssl", "verify", "-CAfile", robot.authority, authority.router.certificate]
    assert subprocess.run(check, capture_output=True).returncode == 0


def test_no_certificate_takes_the_place_of_the_fleets_own_files(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    authority.prepare(("127.0.0.1",))
    own = {path: path.read_bytes() for path in tmp_path.rglob("*.pem")}
    for name, folder in (("authority", tmp_path / "authority"), ("r1", tmp_path / "r1" / ".." / "router")):
        with pytest.raises(BadInput, match="holds the fleet's own files"):
            authority.issue(name, folder, kind="robot")
    assert {path: path.read_bytes() for path in tmp_path.rglob("*.pem")} == own and not authority.certificates()


def test_of_certificates_that_are_made_at_once_all_are_let_in(tmp_path: Path) -> None:
    names = [f"r{number}" for number in range(4)]
    with ThreadPoolExecutor(4) as shells:
        done = [shells.submit(Authority(tmp_path).issue, name, tmp_path / name, kind="robot") for name in names]
    assert {one.result().name for one in done} == {one.name for one in Authority(tmp_path).certificates()} == {*names}


def test_a_key_is_its_owners_alone_before_anything_is_written_into_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    modes: dict[str, int] = {}

    def openssl(*arguments: str) -> None:
        if arguments[0] == "genpkey":
            modes["made"] = Path(arguments[-1]).stat().st_mode & 0o777
        made_by(*arguments)

    def fsync(file: int) -> None:
        name = os.readlink(f"/proc/self/fd/{file}")
        modes[name.rpartition("/")[2].split(".pem")[0]] = os.fstat(file).st_mode & 0o777
        synced(file)

    made_by, synced = authority_module._openssl, os.fsync
    monkeypatch.setattr(authority_module, "_openssl", openssl)
    monkeypatch.setattr(os, "fsync", fsync)
    before = os.umask(0o000)
    try:
        Authority(tmp_path / "fleet").issue("r1", tmp_path / "r1", kind="robot")
    finally:
        os.umask(before)
    assert modes["made"] == 0o600 and modes[".key"] == 0o600


def test_without_openssl_the_command_that_installs_it_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    with pytest.raises(BeckonError, match="apt install openssl"):
        Authority(tmp_path / "fleet").prepare(())
