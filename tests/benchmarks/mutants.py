"""Take away each guard in turn and see whether a test goes red: `python -m tests.benchmarks.mutants [WORD …]`.

Every mutant is one changed line in a copy of the sources; it is killed by a test that is red with it and, at once
after, green without. With words, only mutants whose name holds one of them.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.benchmarks.command import run_command

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("core", "console", "static", "tests", "pyproject.toml", "README.md")
TESTS_TIMEOUT_S = 600.0  # beside whatever else the machine does
MAX_KILLER_TRIES = 3  # to find a killer that is green without the mutant
DRIVER, NEARNESS = "core/robots/process.py", "core/robots/nearness.py"
READINGS, PUBLISHERS = "core/robots/readings.py", "core/sensors/publishers.py"
GATE, DEADMAN = "core/gate/gate.py", "core/gate/deadman.py"
LOOP, SUPERVISOR = "core/gate/process.py", "console/robot/supervisor.py"
GUARD, LATCH, LIMITS = "core/gate/guard.py", "core/gate/latch.py", "core/gate/limits.py"
CONTROL_STORIES = "tests/console/control/test_control_state_machine.py"
DISPATCHER_FILE, STOP_FILE, LEASE_FILE = (
    "console/control/dispatcher.py",
    "console/control/stop.py",
    "console/control/lease.py",
)
FRESHNESS_FILE, ROUTES_FILE = "console/control/command_freshness.py", "console/maps/routes.py"
TESTS = {
    **dict.fromkeys((DISPATCHER_FILE, STOP_FILE, LEASE_FILE, FRESHNESS_FILE, ROUTES_FILE), CONTROL_STORIES),
    DRIVER: "tests/core/robots/test_driver.py",
    NEARNESS: "tests/core/robots/test_driver.py",
    GATE: "tests/core/gate/test_gate.py",
    DEADMAN: "tests/core/gate/test_gate.py",
    LOOP: "tests/core/gate/test_gate_process.py",
    SUPERVISOR: "tests/console/robot/test_supervisor.py",
    GUARD: "tests/core/gate/test_guard.py",
    LATCH: "tests/core/gate/test_latch.py",
    READINGS: "tests/core/robots/test_readings.py",
    PUBLISHERS: "tests/core/sensors/test_publishers.py",
    LIMITS: "tests/core/gate/test_limits.py",
}


@dataclass(frozen=True)
class Mutant:
    """`before` stands once in `file`, and `after` in its place."""

    name: str
    file: str
    before: str
    after: str


CHANGES: dict[str, tuple[tuple[str, str, str], ...]] = {
    DRIVER: (
        ("driver: silence", "now - self._twist_at > TWIST_TIMEOUT_S", "now - self._twist_at > 1e9"),
        (
            "driver: gate gone",
            "self._has_gate, self._until = False, math.inf\n            self._drive(ZERO, time.monotonic())",
            "self._has_gate, self._until = False, math.inf",
        ),
        (
            "driver: other gate",
            "        self._drive(ZERO, time.monotonic())\n        self._gate = packet_socket",
            "        self._gate = packet_socket",
        ),
        ("driver: no number", "fit = is_number(v) and is_number(w)", "fit = is_number(w)"),
        (
            "driver: end",
            "                self._step()\n        self._robot.drive(ZERO)",
            "                self._step()",
        ),
        ("driver: orphan", "self._frame_sender.gone or os.getppid() != self._parent", "self._frame_sender.gone"),
    ),
    NEARNESS: (
        (
            "driver: frozen laser",
            "if not timely or not self._freshness[laser.name].shows(scan, moving=moving):",
            "if not timely:",
        ),
    ),
    DEADMAN: (
        ("gate: deadman", "if now >= arrived + self._limits.deadman:", "if False:"),
        ("gate: heartbeat", "CONSOLE_SILENT if self.console_silent(now) else", '"" if now else'),
    ),
    READINGS: (
        ("readings: two bases", "if self._base.take(odometry, self.now(), source):", "if False:"),
        (
            "readings: two lasers",
            "if self._scanners[name].take(sector_ranges(scan, self._heading(stamp)), self.now(), source):",
            "if False:",
        ),
        ("readings: not said", "trouble=self._mixture(stamp),", 'trouble="",'),
    ),
    PUBLISHERS: (
        ("publishers: another place each time", "return known", "return True"),
        ("publishers: who publishes", "if one.source != other.source", "if False"),
    ),
    GATE: (
        ("gate: late", "if self._ticked is not None and now - self._ticked > LATE_TICK_S:", "if False:"),
        ("gate: blind", "or MAX_BLIND_S < now - self._last_sign < math.inf", ""),
        ("gate: stale scan", "if now - self._last_sign > self.limits.scan_age:", "if False:"),
        ("gate: lease", "if setpoint.epoch != self._epoch:", "if False:"),
        ("gate: nonce", "        if age is None:", "        if False:"),
        ("gate: before stop", "        if not after_stop:", "        if False:"),
        ("gate: need of neutral", '(source == "jog" and self._need_neutral) or ', ""),
        ("gate: trouble", "if now - self._troubled <= TROUBLE_HELD_S:", "if False:"),
        ("gate: older lease", "if not is_count(epoch) or epoch < self._epoch:", "if not is_count(epoch):"),
        ("gate: one holder", 'if epoch == self._epoch and self._owner not in ("", owner):', "if False:"),
        ("gate: malformed", "if not setpoint.is_well_formed:", "if False:"),
        (
            "gate: not armed",
            '        if self._state != "armed":\n            return Statement',
            "        if False:\n            return Statement",
        ),
        ("gate: older frame", "if setpoint.seq <= self._last_seq.get(setpoint.source, -1):", "if False:"),
        ("gate: no number", "if not (is_number(setpoint.v) and is_number(setpoint.w)):", "if False:"),
        ("gate: clock backwards", "return self._ticked is not None and now < self._ticked", "return False"),
        ("gate: seen later", "self._seen = self._heard = self._troubled = -math.inf", "self._troubled = -math.inf"),
        ("gate: young later", "-math.inf\n            self._nonces.mark(now)", "-math.inf"),
        ("gate: silent console obeys", "if self._deadman.console_silent(now):", "if False:"),
        ("gate: over press", "if not self._presses.begin(source, press):", "if False:"),
        ("gate: bumper", "if self._contact and wanted.v * self._contact_side > 0.0:", "if False:"),
        ("gate: late scan counts", "if age > self.limits.scan_age:", "if False:"),
    ),
    LOOP: (
        ("loop: sleep", "                self._look_for_sleep()\n", ""),
        ("loop: console gone", "        if not there:\n            self._console_gone()", ""),
        ("loop: number of a halt", "self._latched = number", "self._latched = 10**6"),
        ("loop: parent gone", "if os.getppid() != parent:", "if False:"),
    ),
    SUPERVISOR: (
        ("supervisor: sleep", '            self._insist("stop")\n            self.alarm', "            self.alarm"),
        ("supervisor: forgiven", "self._restarts.forgive(now) if excused else ", ""),
        ("supervisor: frozen gate", "if now - max(gate.heard, self._woke_at) > patience:", "if False:"),
        (
            "supervisor: no means",
            "            except (OSError, MemoryError) as trouble:\n                why",
            "            except ArithmeticError as trouble:\n                why",
        ),
    ),
    GUARD: (
        ("guard: no points", "if is_number(point[0]) and is_number(point[1])]", "]"),
        (
            "guard: turning inside",
            '        return Permitted(ZERO, 0.0, nearest, Statement("gate.reason_inside"))',
            "        return Permitted(twist)",
        ),
        ("guard: crawls on", "if allowed < CRAWL_SPEED_M_S:", "if False:"),
    ),
    LATCH: (
        (
            "latch: unreadable is free",
            "        except OSError:\n            return True",
            "        except OSError:\n            return False",
        ),
        ("latch: file not on disk", "            os.fsync(file.fileno())\n", ""),
    ),
    DISPATCHER_FILE: (
        (
            "dispatcher: viewers drive",
            '        if not who.may("operator"):\n            raise Problem(403, VIEWERS_WATCH)\n        profile',
            "        profile",
        ),
        (
            "dispatcher: words are never void",
            "            if said is not None:\n                self.freshness.check(said, source, who)\n",
            "",
        ),
        (
            "dispatcher: cancelled and driving",
            "        self._active.cancel()\n        for number in self._active:\n"
            "            self.setpoint_sender.revoke(number)\n",
            "        self._active.cancel()\n",
        ),
        (
            "dispatcher: handed over as it is",
            '        self.cancel("cancelled", why)\n        holder',
            "        holder",
        ),
        (
            "dispatcher: link lost and driving",
            "        for number in self._active:\n            self.setpoint_sender.revoke(number)\n"
            '            self._history.end(number, "failed", why)\n',
            '        for number in self._active:\n            self._history.end(number, "failed", why)\n',
        ),
        (
            "dispatcher: not moving and authorized",
            " and spec_of(heard.name).moves:\n            self.setp",
            ":\n            self.setp",
        ),
    ),
    STOP_FILE: (
        ("stop: what waits goes on", '        self._cancel("cancelled", why, who)\n', ""),
        (
            "stop: anybody lifts a halt",
            '        if not who.may("operator"):\n'
            '            raise Problem(403, Statement("stop.only_operators_reset"))\n',
            "",
        ),
    ),
    LEASE_FILE: (
        (
            "lease: two drive",
            "if self.holder is not None and not self.held_by(person):\n            raise Refused(OTHER",
            "if False:\n            raise Refused(OTHER",
        ),
    ),
    FRESHNESS_FILE: (("words: said before a stop", "if stop is not None and said.began < stop.at:", "if False:"),),
    ROUTES_FILE: (
        ("routes: on after a restart", 'found.state, found.command = "ended", None', "found.command = None"),
        (
            "routes: on after a stop",
            'if self._own or run is None or run.state not in ("driving", "waiting"):',
            'if self._own or run is None or run.state != "driving":',
        ),
    ),
    LIMITS: (("limits: endless numbers", "type(value) is float and math.isfinite(value)", "type(value) is float"),),
}
"""By file: the name of a mutant, what stands once in the file, and what stands there instead."""

MUTANTS = tuple(Mutant(name, file, before, after) for file, rows in CHANGES.items() for name, before, after in rows)


def first_failure(tests: Sequence[str], copy: Path) -> str:
    """The first of these tests that is not green in the copy; "": all are."""
    command = [sys.executable, "-m", "pytest", "-n0", "-x", "-q", "-rfE", "-p", "no:cacheprovider", *tests]
    environment = {**os.environ, "PYTHONPATH": str(copy)}
    try:
        done = subprocess.run(
            command, cwd=copy, env=environment, capture_output=True, text=True, timeout=TESTS_TIMEOUT_S, check=False
        )
    except subprocess.TimeoutExpired:
        return " ".join(tests)  # a test that waits for ever is red
    named = re.search(r"^(?:FAILED|ERROR) (tests/.+?)(?: - |$)", done.stdout, re.MULTILINE)
    return "" if done.returncode == 0 else named[1] if named else " ".join(tests)


def killer(mutant: Mutant, copy: Path) -> str:
    """The test that is red with it and green without; "": it survives. Raises SystemExit where none can be named."""
    path = copy / mutant.file
    source = path.read_text()
    if source.count(mutant.before) != 1:
        raise SystemExit(
            f"{mutant.name}: what it changes stands {source.count(mutant.before)} times in {mutant.file}."
        )
    red = ""
    for _ in range(MAX_KILLER_TRIES):
        path.write_text(source.replace(mutant.before, mutant.after))
        try:
            red = first_failure(TESTS[mutant.file].split(), copy)
        finally:
            path.write_text(source)
        if not red or not first_failure([red], copy):
            return red
    raise SystemExit(f"{red} fails on unchanged code: nothing is shown by it.")


def killers(chosen: Sequence[Mutant]) -> dict[str, str]:
    """What kills each, by its name; "": nothing does."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in COPIED:
            source = ROOT / name
            (shutil.copytree if source.is_dir() else shutil.copy)(source, copy / name)
        found: dict[str, str] = {}
        for mutant in chosen:
            found[mutant.name] = killer(mutant, copy)
            sys.stderr.write(f"{mutant.name}: {found[mutant.name] or 'SURVIVED'}\n")
    return found


def main() -> object:
    """Print what kills each, as JSON."""
    words = sys.argv[1:]
    chosen = [mutant for mutant in MUTANTS if not words or any(word in mutant.name for word in words)]
    found = killers(chosen)
    survived = [name for name, test in found.items() if not test]
    return {"mutants": len(chosen), "survived": survived, "killers": found}


if __name__ == "__main__":
    run_command(main)
