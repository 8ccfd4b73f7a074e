"""The measurements of the campaign, each made of the benchmark that knows how."""

import contextlib
import itertools
import json
import math
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
from playwright.sync_api import Page, sync_playwright
from websockets.sync.client import connect

from core.gate import Limits, check, read_trace
from tests.benchmarks import (
    gate_timing,
    halt_kills,
    history_kills,
    late_scans,
    mutants,
    no_motion,
    obstacles,
    process_kills,
    recorder_kills,
    sleeping,
    soak,
    state_machine,
    strangers,
)
from tests.benchmarks.real_sessions import SUBJECTS
from tests.benchmarks.running_console import Console, console, watch
from tests.campaign import struck
from tests.campaign.figures import ROOT, Effort, RowFigure, none_of, p99, worst
from tests.emulators.robot_process import robot_process
from tests.stories.words_in_time import told_story

DRIVERS = ("sim", "foxglove", "serial+scip")
WIRE_DRIVERS = DRIVERS[1:]
SHARED_WIRES = ("foxglove", "rosbridge", "zenoh")  # on which robots can have the same names
READY_S = 60.0
HEAP_READINGS = 30
WARM_UP_S = 60.0  # after which a page holds as much of the past as it ever shows
BYTES_PER_MB = 1e6


def browser_closed(effort: Effort) -> Iterator[RowFigure]:
    for driver in DRIVERS:
        yield worst("to zero", struck.closed(driver, effort.trials), 100.0, driver)


def browser_frozen(effort: Effort) -> Iterator[RowFigure]:
    for driver in DRIVERS:
        times, ghosts = struck.frozen(driver, effort.trials)
        yield worst("to zero", times, 300.0, driver)
        yield none_of("motion after the thaw", ghosts, effort.trials, "trials", driver)


def link_frozen(effort: Effort) -> Iterator[RowFigure]:
    times, ghosts = struck.frozen_links("sim", effort.trials)
    yield worst("to zero", times, 300.0)
    yield none_of("motion by frames that the link kept", ghosts, effort.trials, "trials")
    trips = struck.false_trips(effort.seconds, effort.seed)
    yield RowFigure(
        "false stops at a jitter of 0.1 s",
        round(60 * trips / effort.seconds, 2),
        "a minute",
        1.0,
        round(effort.seconds),
    )


def console_dies(effort: Effort) -> Iterator[RowFigure]:
    """On wires, whose gate has the machine's clock: a simulated world stands still with its console."""
    for driver in WIRE_DRIVERS:
        some = max(2, effort.trials // 3)
        yield worst("to zero, killed", struck.console_faults(driver, some, signal.SIGKILL), 150.0, driver)
        yield worst("to zero, frozen", struck.console_faults(driver, some, signal.SIGSTOP), 300.0, driver)


def driver_stuck(effort: Effort) -> Iterator[RowFigure]:
    """On wires alone: a simulated world that is frozen has no time."""
    for driver in WIRE_DRIVERS:
        yield worst("to zero at the gate", struck.driver_frozen(driver, max(2, effort.trials // 3)), 500.0, driver)


def stop_command(effort: Effort) -> Iterator[RowFigure]:
    times = struck.stops_under_load("sim", 5 * effort.trials, viewers=50)
    yield p99("to zero, 50 viewers and one stuck", times, 25.0)
    yield worst("to zero, 50 viewers and one stuck", times, 100.0)


@contextlib.contextmanager
def page_of(running: Console) -> Iterator[Page]:
    """The console's page in Chromium, without the 3-D map."""
    with sync_playwright() as playwright:
        arguments = ["--disable-gpu", "--no-sandbox"]
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=arguments)
        page = browser.new_page()
        page.set_default_timeout(1000 * READY_S)
        page.route("**/scene/**", lambda route: route.fulfill(body="", content_type="text/html"))
        page.add_init_script("localStorage.setItem('beckon.hints', 'seen')")
        page.goto(f"http://127.0.0.1:{running.port}/")
        page.wait_for_selector("link-chip:has-text('Hz')")
        yield page
        browser.close()


def stop_clicked(effort: Effort) -> Iterator[RowFigure]:
    times: list[float] = []
    with console() as running, page_of(running) as page:
        box = page.locator("stop-button .stop").bounding_box()
        assert box is not None
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        for _ in range(effort.trials):
            running.post("/api/commands", {"text": "turn left"})
            struck.until(lambda: struck.moving(running.trace), READY_S)
            time.sleep(0.2)
            with struck.TraceOnlooker(running.trace) as onlooker:
                instant = time.monotonic_ns()
                page.mouse.down()
                page.mouse.up()
                times.append(onlooker.zero_after(instant))
    yield p99("click to zero, end to end", times, 60.0)


def halts_kept(effort: Effort) -> Iterator[RowFigure]:
    for after in (False, True):
        outcomes = halt_kills.campaign(effort.trials, effort.seed + after, after_answer=after)
        when = "after the answer" if after else "around the write"
        yield none_of(f"halts forgotten, killed {when}", outcomes["forgotten"], effort.trials, "halts")


def never_by_itself(effort: Effort) -> Iterator[RowFigure]:
    """The events of the benchmark on each wire; the largest of the motions after them."""
    for driver in WIRE_DRIVERS:
        moved = no_motion.run(driver)
        event, far = max(moved.items(), key=lambda one: one[1])
        bound, tried = no_motion.STANDS, len(moved)
        yield RowFigure("motion after an event", round(far, 4), "m", bound, tried, driver, f"Most after: {event}.")


def any_order(effort: Effort) -> Iterator[RowFigure]:
    """Whatever may happen to a gate, and to all that decides what drives: nothing moves without consent."""
    for name, machine in state_machine.STATE_MACHINES.items():
        found = [state_machine.run(machine, number) for number in range(effort.seed, effort.seed + effort.trials)]
        violations = [violation for _, violation in found if violation]
        why = " ".join([f"{len(found)} seeds", *violations]).replace("\n", " ")
        steps = sum(some for some, _ in found)
        yield RowFigure("violations of the state machine", len(violations), "steps", 0.0, steps, name, why)


def two_consoles(effort: Effort) -> Iterator[RowFigure]:
    for driver in WIRE_DRIVERS:
        with robot_process(*SUBJECTS[driver]) as robot, contextlib.ExitStack() as stack:
            moved = no_motion.second_console(no_motion.Trial(driver, robot, stack))
            yield RowFigure("motion when a second console comes", round(moved, 4), "m", no_motion.STANDS, 1, driver)


def late_cells(effort: Effort, lies: tuple[str, ...]) -> Iterator[RowFigure]:
    """The table of late scans: through each driver's code on simulated time, and over real wires."""
    late = late_scans.LATE_S[:: 1 if effort.trials > 20 else 3]
    for driver, make in late_scans.DRIVERS.items():
        cells = list(itertools.product(late, late_scans.SPEEDS_M_S, lies))
        found = [late_scans.drive(make(), seconds, speed, late_scans.LIES[lie]) for seconds, speed, lie in cells]
        contacts = sum(one.gap < 0 for one in found)
        yield none_of("contacts, late by 0 to 5 s at 0.1 to 0.5 m/s", contacts, len(cells), "drives", driver)
    named = [lie for lie in lies if lie != "no number"]  # no wire carries one
    for driver in WIRE_DRIVERS:
        cells = list(itertools.product(late_scans.WIRE_LATE_S, late_scans.SPEEDS_M_S, named))
        chosen = cells if effort.trials > 20 else random.Random(effort.seed).sample(cells, 4)
        found = [
            late_scans.drive_wires(driver, seconds, speed, late_scans.LIES[lie]) for seconds, speed, lie in chosen
        ]
        contacts = sum(one.gap < 0 for one in found)
        yield none_of("contacts over its emulator, late by 0 to 5 s", contacts, len(chosen), "drives", driver)


def late_readings(effort: Effort) -> Iterator[RowFigure]:
    yield from late_cells(effort, ("honest",))


def lying_stamps(effort: Effort) -> Iterator[RowFigure]:
    yield from late_cells(effort, ("no number", "future", "backward"))


def things_in_the_way(effort: Effort) -> Iterator[RowFigure]:
    put = [obstacles.placement(seed) for seed in range(effort.seed, effort.seed + 4 * effort.trials)]
    yield none_of("contacts at 0.3 m/s", sum(bool(one["contact"]) for one in put), len(put), "drives")


def words_in_stories(effort: Effort) -> Iterator[RowFigure]:
    stories = 50 * effort.trials
    with tempfile.TemporaryDirectory() as folder:
        wrong = sum(
            len(told_story(number, Path(folder)).wrong) for number in range(effort.seed, effort.seed + stories)
        )
    yield none_of("motions by old or void words", wrong, stories, "stories")


def under_attack(effort: Effort) -> Iterator[RowFigure]:
    for name in ("four different", "1,200 half requests"):
        with console(auth=True) as running:
            time.sleep(2.0)
            figures = strangers.measured(running, strangers.CASES[name], 20 * effort.trials)
        yield RowFigure(f"STOP, p99, {name}", figures["stop_ms"]["p99"], "ms", 25.0, 20 * effort.trials)
    figures = strangers.all_at_once(100 * effort.trials)
    for what, values in (("STOP", "stop_ms"), ("lateness of the pilot", "pilot_late_p99_ms")):
        figure, name = figures[values], "52 viewers, calibration, recording, four strangers"
        yield RowFigure(f"{what}, p99, {name}", figure.get("p99", figure["max"]), "ms", 25.0, 100 * effort.trials)


def many_viewers(effort: Effort) -> Iterator[RowFigure]:
    """Fifty who look on and one who never reads: the operator's round trip, and the console's memory."""
    with console(auth=True) as running, contextlib.ExitStack() as stack:
        own = psutil.Process(running.process.pid)
        time.sleep(2.0)
        before = own.memory_info().rss
        watch(running, 50, stack)
        figures = strangers.measured(running, (), 20 * effort.trials)
        grown = (own.memory_info().rss - before) / BYTES_PER_MB
    yield RowFigure("round trip of the operator, p99", figures["echo_ms"]["p99"], "ms", 25.0, 20 * effort.trials)
    yield RowFigure("memory for 50 viewers and one stuck", round(grown, 1), "MB", 50.0, 1)


def rows_kept(effort: Effort) -> Iterator[RowFigure]:
    chance, given, lost = random.Random(effort.seed), 0, 0
    for _ in range(max(3, effort.trials // 2)):
        with tempfile.TemporaryDirectory() as folder:
            some, missing = history_kills.kill(Path(folder), chance.uniform(0.5, 3.0))
        given, lost = given + some, lost + missing
    yield none_of("acknowledged rows of the history lost", lost, given, "rows")
    killed = [recorder_kills.killed_recorder(chance) for _ in range(effort.trials)]
    due = sum(one["due"] for one in killed)
    yield none_of("readings lost that were older than 1 s", sum(one["missing"] for one in killed), due, "readings")


def everything_killed(effort: Effort) -> Iterator[RowFigure]:
    """Each process in turn is killed while the robot drives → until all is up again, the next console included."""
    found = list(process_kills.campaign(WIRE_DRIVERS[0], effort.trials, effort.seed))
    for process in process_kills.KILLED_PROCESSES:
        name, times = process.removeprefix("--worker="), [one.up_s for one in found if one.process == process]
        yield worst(f"up again, {name} killed", times, 5.0, WIRE_DRIVERS[0], unit="s")
    answered, lost = sum(one.answered for one in found), sum(one.lost for one in found)
    yield none_of("answered commands lost, each process killed", lost, answered, "commands", WIRE_DRIVERS[0])


def own_failsafe(effort: Effort) -> Iterator[RowFigure]:
    """Gate, driver or console are killed in a turn → [ms] until the robot's wheels rest, by its own record."""
    for driver in WIRE_DRIVERS:
        killed = (process_kills.GATE, process_kills.DRIVER, process_kills.CONSOLE)
        found = list(process_kills.campaign(driver, max(2, effort.trials // 3), effort.seed, killed))
        for process in killed:
            times = [one.rest_ms for one in found if one.process == process and one.rest_ms is not None]
            yield worst(f"to rest, {process} killed", times, process_kills.rest_bound_ms(process), driver)


def backlog(effort: Effort) -> Iterator[RowFigure]:
    """A console that stood for 6 s with a hand's frames waiting: who holds the key stays, nothing moves."""
    thrown, moved, trials = 0, 0, max(2, effort.trials // 3)
    for _ in range(trials):
        with console() as running, struck.hand(running) as holding:
            struck.until(lambda running=running: struck.moving(running.trace))
            running.process.send_signal(signal.SIGSTOP)
            time.sleep(6.0)
            woken = len(read_trace(running.trace))
            running.process.send_signal(signal.SIGCONT)
            time.sleep(3.0)
            thrown += holding.poll() is not None
            moved += struck.moves_from(running.trace, woken)
    yield none_of("operators thrown out", thrown, trials, "trials")
    yield none_of("motion by what waited", moved, trials, "trials")


FILE_DAMAGES = ("cut", "flipped", "empty", "garbage")


def damage(path: Path, how: str, chance: random.Random) -> None:
    whole = path.read_bytes()
    if how == "cut":
        path.write_bytes(whole[: chance.randrange(len(whole)) if whole else 0])
    elif how == "flipped" and whole:
        at = chance.randrange(len(whole))
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x10]) + whole[at + 1 :])
    else:
        path.write_bytes(b"" if how == "empty" else chance.randbytes(300))


def damaged_stores(effort: Effort) -> Iterator[RowFigure]:
    """Every kind of file of a used data folder is damaged: the console starts, or says in a sentence which file."""
    chance, failed, named = random.Random(effort.seed), 0, list[str]()
    with tempfile.TemporaryDirectory() as folder:
        used = Path(folder) / "used"
        used.mkdir()
        _use(used)
        files = sorted(
            path.relative_to(used)
            for path in used.rglob("*")
            if path.is_file() and not path.name.startswith(("console.log", "gate.csv", "lock"))
        )
        cases = list(itertools.product(files, FILE_DAMAGES))
        chosen = chance.sample(cases, min(len(cases), effort.trials))
        for number, (name, how) in enumerate(chosen):
            home = Path(folder) / str(number)
            shutil.copytree(used, home)
            damage(home / name, how, chance)
            if not _starts(home):
                failed += 1
                named.append(f"{name} {how}")
    yield RowFigure(
        "starts that ended without a sentence", float(failed), "starts", 0.0, len(chosen), "sim", ", ".join(named)
    )


def _use(home: Path) -> None:
    """Have something of every kind in the data folder."""
    running = Console(home)
    try:
        struck.until(lambda: not running.get("/api/health")["reasons"], READY_S)
        running.answer("/api/commands", {"text": "turn left"})
        time.sleep(3.0)
        for path, body in (
            ("/api/places", {"name": "door", "x_m": 0.5, "y_m": 0.0, "heading_rad": None}),
            ("/api/maps", {"name": "lab"}),
            ("/api/recordings/start", {"name": "drive"}),
            ("/api/recordings/stop", {}),
        ):
            with contextlib.suppress(OSError):
                running.answer(path, body)
        running.answer("/api/halt")
    finally:
        running.close()


def _starts(home: Path) -> bool:
    """Whether a console comes and answers, or refuses in one sentence without a traceback."""
    command = [sys.executable, "-m", "console", "run", "--no-browser", "--port", "0", "--nobody", "--no-auth"]
    with subprocess.Popen(
        [*command, "--data", str(home)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT
    ) as process:
        assert process.stdout is not None and process.stderr is not None
        came = "127.0.0.1:" in process.stdout.readline()
        process.terminate()
        said = process.stderr.read()
        process.wait()
    return "Traceback" not in said and (came or bool(said.strip()))


def told_to_end(effort: Effort) -> Iterator[RowFigure]:
    for driver in WIRE_DRIVERS:
        times = struck.console_faults(driver, max(2, effort.trials // 3), signal.SIGTERM)
        yield worst("SIGTERM to zero", times, 100.0, driver)


def slept(effort: Effort) -> Iterator[RowFigure]:
    with sleeping.shim() as page:
        moved = [1000 * sleeping.trial(page) for _ in range(max(2, effort.trials // 3))]
    yield worst("motion after 6 s of sleep", moved, 20.0)


def comings_and_goings(effort: Effort) -> Iterator[RowFigure]:
    """Sockets that come and go: descriptors and memory of the console return to where they were."""
    with console() as running:
        own, origin = psutil.Process(running.process.pid), f"http://127.0.0.1:{running.port}"
        url = f"ws://127.0.0.1:{running.port}/ws"

        def come_and_go(times: int) -> None:
            for _ in range(times):
                with connect(url, origin=origin, compression=None) as line:  # type: ignore[arg-type]
                    line.recv(timeout=10)

        come_and_go(30)
        time.sleep(2.0)
        files, memory = own.num_fds(), own.memory_info().rss
        cycles = 50 * effort.trials
        come_and_go(cycles)
        time.sleep(3.0)
        grown = 100 * (own.memory_info().rss / memory - 1)
        yield RowFigure("descriptors left open", float(max(0, own.num_fds() - files)), "descriptors", 1.0, cycles)
        yield RowFigure("memory grown", round(grown, 1), "%", 5.0, cycles)


def audited(effort: Effort) -> Iterator[RowFigure]:
    """Random orders by every way: the trace breaks no rule, and no motion begins outside a command of the history."""
    with console() as running:
        struck.until(lambda: not running.get("/api/health")["reasons"], READY_S)
        soak.Soak(running, effort.seed).run(effort.seconds)
        running.post("/api/stop")
        time.sleep(0.5)
        rows = read_trace(running.trace)
        complaints = check(rows, Limits())
        owned = all(row.epoch > 0 for row in rows if row.v or row.w)
    yield none_of("rules of the trace broken", len(complaints), len(rows), "rows")
    yield none_of("rows that move without an owner", int(not owned), len(rows), "rows")


OFFLINE = """
import fcntl, socket, struct, sys, tempfile
from pathlib import Path
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
    fcntl.ioctl(line, 0x8914, struct.pack("16sh", b"lo", 0x41))  # SIOCSIFFLAGS: up and running
from tests.benchmarks.running_console import Console
from tests.campaign.struck import moving, until
with tempfile.TemporaryDirectory() as folder:
    running = Console(Path(folder))
    try:
        until(lambda: not running.get("/api/health")["reasons"], 90)
        assert b"<html" in running.download("/")
        running.answer("/api/commands", {"text": "turn left"})
        until(lambda: moving(running.trace), 30)
    finally:
        running.close()
print("done")
"""


def offline(effort: Effort) -> Iterator[RowFigure]:
    """A network namespace that has nothing but the loopback device."""
    done = subprocess.run(
        ["unshare", "-rn", sys.executable, "-c", OFFLINE], cwd=ROOT, capture_output=True, text=True, timeout=200
    )
    fine = done.stdout.strip().endswith("done")
    why = "" if fine else done.stderr.strip().rpartition("\n")[2]
    yield RowFigure("starts that needed a network", float(not fine), "starts", 0.0, 1, "sim", why)


def ticks(effort: Effort) -> Iterator[RowFigure]:
    with gate_timing.busy(2):
        gaps = [1000 * gap for gap in gate_timing.tick_gaps(effort.seconds)]
    yield p99("tick gap beside two busy loops", gaps, 30.0)
    yield worst("tick gap beside two busy loops", gaps, 60.0)


HOSTILE = '<img src=x onerror="window.__struck=1">'


def hostile_names(effort: Effort) -> Iterator[RowFigure]:
    """Markup as words, as the note of a recording, as names: the page runs none of it."""
    ways = (
        ("/api/commands", {"text": HOSTILE}),
        ("/api/recordings/start", {"name": "drive", "note": HOSTILE}),
        ("/api/places", {"name": HOSTILE, "x_m": 0.0, "y_m": 0.0, "heading_rad": None}),
        ("/api/maps", {"name": HOSTILE}),
        ("/api/sim/say", {"text": HOSTILE, "x_m": 1.0, "y_m": 0.0}),
        ("/api/sim/place", {"what": "person", "id": HOSTILE, "x_m": 1.0, "y_m": 0.0}),
    )
    struck_pages = 0
    addresses = ("", "people", "hearing", "maps", "recordings", "experiments", "connect", "calibrate")
    with console() as running:
        struck.until(lambda: not running.get("/api/health")["reasons"], READY_S)
        for path, body in ways:
            with contextlib.suppress(OSError):
                running.answer(path, body)
        with page_of(running) as page:
            for address in addresses:
                page.goto(f"http://127.0.0.1:{running.port}/{address}")
                page.wait_for_timeout(1500)
                struck_pages += page.evaluate("window.__struck !== undefined")
    yield none_of("pages on which markup in names ran", struck_pages, len(addresses), "pages")


def long_page(effort: Effort) -> Iterator[RowFigure]:
    """A page that is left open: its heap after a collection, from when its charts and lists are full."""
    with console() as running, page_of(running) as page:
        line = page.context.new_cdp_session(page)

        def heap() -> float:
            line.send("HeapProfiler.collectGarbage")
            return float(line.send("Runtime.getHeapUsage")["usedSize"]) / BYTES_PER_MB

        page.wait_for_timeout(1000 * WARM_UP_S)
        found: list[float] = []
        for _ in range(HEAP_READINGS):
            page.wait_for_timeout(1000 * effort.seconds / HEAP_READINGS)
            found.append(heap())  # one in twenty is 0.3 MB off: medians of the first and the last third count
        third = HEAP_READINGS // 3
        grown = (statistics.median(found[-third:]) - statistics.median(found[:third])) * 3600 / effort.seconds * 1.5
    yield RowFigure("heap of the page", round(max(0.0, grown), 1), "MB an hour", 5.0, round(effort.seconds))


def long_life(effort: Effort) -> Iterator[RowFigure]:
    """Random orders and patrols on a whole floor, recorded and looked at; each minute is said on standard error."""
    minutes: list[dict[str, Any]] = []
    with console(robot="sim:floor") as running:
        struck.until(lambda: not running.get("/api/health")["reasons"], READY_S)
        for minute in soak.long_life(running, effort.seconds, effort.seed):
            minutes.append(minute)
            sys.stderr.write(json.dumps(minute) + "\n")
        faults = len(running.faults())
    yield from risen(minutes, faults)


def risen(minutes: list[dict[str, Any]], faults: int) -> Iterator[RowFigure]:
    """What rises after the warm-up: robust slopes of the minutes, with their intervals of 95 %."""
    lived = minutes[min(soak.WARM_UP_MIN, len(minutes) // 2) :]
    warm_up, trials = len(minutes) - len(lived), round(soak.EVERY * len(minutes))
    ran = f"{len(minutes)} minutes of real time instead of a simulated day, which takes a day; {warm_up} to warm up"
    slope, low, high = soak.rise([sum(one["memory_mb"].values()) for one in lived])
    why = f"{ran}; 95 %: {low:.1f} to {high:.1f}"
    yield RowFigure("memory of all processes", round(max(0.0, slope), 1), "MB a day", 2.0, trials, "sim", why)
    kept = [sum(mb for name, mb in one["disk_mb"].items() if name not in soak.GROWING_FILES) for one in lived]
    slope, low, high = soak.rise(kept)
    why = f"95 %: {low:.1f} to {high:.1f}; without the recording that runs"
    yield RowFigure("data folder", round(max(0.0, slope), 1), "MB a day", 20.0, trials, "sim", why)
    for what in ("descriptors", "threads"):
        sums = [sum(one[what].values()) for one in lived]
        grown = statistics.median(sums[-10:]) - statistics.median(sums[:10])
        yield none_of(f"{what} more at the end", max(0, round(grown)), trials, what)
    errors = sum(count for what, count in minutes[-1]["answers"].items() if " 500" in what)
    yield none_of("faults in the log and answers with one", faults + errors, trials, "faults")


def mutants_killed(effort: Effort) -> Iterator[RowFigure]:
    alive = [name for name, test in mutants.killers(mutants.MUTANTS).items() if not test]
    yield RowFigure(
        "mutants that survive", float(len(alive)), "mutants", 0.0, len(mutants.MUTANTS), "suite", ", ".join(alive)
    )


def two_robots_on_one_wire(effort: Effort) -> Iterator[RowFigure]:
    """Readings of a second robot, which stays where it is, come between those of the one that drives at a wall."""
    honest = late_scans.LIES["honest"]
    cells = list(itertools.product(late_scans.OTHER_ROBOT_TOPICS, late_scans.SPEEDS_M_S))
    for driver in late_scans.WIRES_SHARED:
        make = late_scans.DRIVERS[driver]
        found = [late_scans.drive(make(), 0.0, speed, honest, stranger=what) for what, speed in cells]
        yield none_of("contacts", sum(one.gap < 0 for one in found), len(cells), "drives", driver)
        yield none_of("drives that went on", sum(one.zero is None for one in found), len(cells), "drives", driver)
    for wires in SHARED_WIRES:
        found = [late_scans.drive_wires(wires, 0.0, speed, honest, stranger=what) for what, speed in cells]
        contacts = sum(one.gap < 0 for one in found)
        yield none_of("contacts over its emulator", contacts, len(cells), "drives", wires)
        slowest = max(math.inf if one.zero is None else one.zero for one in found)
        blind = 1000 * late_scans.BLIND_S
        yield RowFigure("second robot to standstill", round(1000 * slowest), "ms", blind, len(cells), wires)
