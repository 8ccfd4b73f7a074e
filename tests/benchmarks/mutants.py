"""Take away each guard in turn and see whether a test goes red: `python -m tests.benchmarks.mutants [WORD …]`.

Every mutant is one changed line in a copy of the sources. With words, only mutants whose name holds one of them.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("core", "console", "static", "tests", "pyproject.toml", "README.md")
TESTS_TIMEOUT_S = 300.0
DRIVER, NEARNESS = "core/robots/process.py", "core/robots/nearness.py"
GATE, DEADMAN = "core/gate/gate.py", "core/gate/deadman.py"
LOOP, SUPERVISOR = "core/gate/process.py", "console/robot/supervisor.py"
GUARD, LATCH, LIMITS = "core/gate/guard.py", "core/gate/latch.py", "core/gate/limits.py"
TESTS = {
    DRIVER: "tests/core/robots/test_driver.py",
    NEARNESS: "tests/core/robots/test_driver.py",
    GATE: "tests/core/gate/test_gate.py",
    DEADMAN: "tests/core/gate/test_gate.py",
    LOOP: "tests/core/gate/test_gate_process.py",
    SUPERVISOR: "tests/console/robot/test_supervisor.py",
    GUARD: "tests/core/gate/test_guard.py",
    LATCH: "tests/core/gate/test_latch.py",
    LIMITS: "tests/core/gate/test_limits.py",
}


@dataclass(frozen=True)
class Mutant:
    """`before` stands once in `file`, and `after` in its place."""

    name: str
    file: str
    before: str
    after: str


MUTANTS = (
    Mutant("driver: silence", DRIVER, "now - self._twist_at > TWIST_TIMEOUT_S", "now - self._twist_at > 1e9"),
    Mutant(
        "driver: gate gone",
        DRIVER,
        "            self._has_gate, self._until = False, math.inf\n            self._drive(ZERO, time.monotonic())",
        "            self._has_gate, self._until = False, math.inf",
    ),
    Mutant(
        "driver: other gate",
        DRIVER,
        "        self._drive(ZERO, time.monotonic())\n        self._gate = packet_socket",
        "        self._gate = packet_socket",
    ),
    Mutant("driver: no number", DRIVER, "fit = is_number(v) and is_number(w)", "fit = is_number(w)"),
    Mutant(
        "driver: end",
        DRIVER,
        "                self._step()\n        self._robot.drive(ZERO)",
        "                self._step()",
    ),
    Mutant(
        "driver: orphan", DRIVER, "self._frame_sender.gone or os.getppid() != self._parent", "self._frame_sender.gone"
    ),
    Mutant(
        "driver: frozen laser",
        NEARNESS,
        "if not timely or not self._freshness[laser.name].shows(scan, moving=moving):",
        "if not timely:",
    ),
    Mutant("gate: deadman", DEADMAN, "if now >= arrived + self._limits.deadman:", "if False:"),
    Mutant("gate: heartbeat", DEADMAN, "CONSOLE_SILENT if self.console_silent(now) else", '"" if now else'),
    Mutant("gate: late", GATE, "if self._ticked is not None and now - self._ticked > LATE_TICK_S:", "if False:"),
    Mutant("gate: blind", GATE, "or MAX_BLIND_S < now - self._last_sign < math.inf", ""),
    Mutant("gate: stale scan", GATE, "if now - self._last_sign > self.limits.scan_age:", "if False:"),
    Mutant("gate: lease", GATE, "if setpoint.epoch != self._epoch:", "if False:"),
    Mutant("gate: nonce", GATE, "        if age is None:", "        if False:"),
    Mutant("gate: before stop", GATE, "        if not after_stop:", "        if False:"),
    Mutant("gate: need of neutral", GATE, '(source == "jog" and self._need_neutral) or ', ""),
    Mutant("loop: sleep", LOOP, "                self._look_for_sleep()\n", ""),
    Mutant("loop: console gone", LOOP, "        if not there:\n            self._console_gone()", ""),
    Mutant("loop: number of a halt", LOOP, "self._latched = number", "self._latched = 10**6"),
    Mutant(
        "supervisor: sleep",
        SUPERVISOR,
        '            self._insist("stop")\n            self.alarm',
        "            self.alarm",
    ),
    Mutant("supervisor: forgiven", SUPERVISOR, "self._restarts.forgive(now) if excused else ", ""),
    Mutant("supervisor: frozen gate", SUPERVISOR, "if now - max(gate.heard, self._woke_at) > patience:", "if False:"),
    Mutant(
        "supervisor: no means",
        SUPERVISOR,
        "            except (OSError, MemoryError) as trouble:\n                why",
        "            except ArithmeticError as trouble:\n                why",
    ),
    Mutant("loop: parent gone", LOOP, "if os.getppid() != parent:", "if False:"),
    Mutant("gate: older lease", GATE, "if not is_count(epoch) or epoch < self._epoch:", "if not is_count(epoch):"),
    Mutant("gate: one holder", GATE, 'if epoch == self._epoch and self._owner not in ("", owner):', "if False:"),
    Mutant("gate: malformed", GATE, "if not setpoint.is_well_formed:", "if False:"),
    Mutant(
        "gate: not armed",
        GATE,
        '        if self._state != "armed":\n            return Statement',
        "        if False:\n            return Statement",
    ),
    Mutant("gate: older frame", GATE, "if setpoint.seq <= self._last_seq.get(setpoint.source, -1):", "if False:"),
    Mutant("gate: no number", GATE, "if not (is_number(setpoint.v) and is_number(setpoint.w)):", "if False:"),
    Mutant("gate: clock backwards", GATE, "if self._ticked is not None and now < self._ticked:", "if False:"),
    Mutant("gate: silent console obeys", GATE, "if self._deadman.console_silent(now):", "if False:"),
    Mutant("gate: over press", GATE, "if not self._presses.begin(source, press):", "if False:"),
    Mutant("gate: bumper", GATE, "if self._contact and wanted.v * self._contact_side > 0.0:", "if False:"),
    Mutant("gate: late scan counts", GATE, "if age > self.limits.scan_age:", "if False:"),
    Mutant("guard: no points", GUARD, "if is_number(point[0]) and is_number(point[1])]", "]"),
    Mutant(
        "guard: turning inside",
        GUARD,
        '        return Permitted(ZERO, 0.0, nearest, Statement("gate.reason_inside"))',
        "        return Permitted(twist)",
    ),
    Mutant("guard: crawls on", GUARD, "if allowed < CRAWL_SPEED_M_S:", "if False:"),
    Mutant(
        "latch: unreadable is free",
        LATCH,
        "        except OSError:\n            return True",
        "        except OSError:\n            return False",
    ),
    Mutant("latch: file not on disk", LATCH, "            os.fsync(file.fileno())\n", ""),
    Mutant(
        "limits: endless numbers", LIMITS, "type(value) is float and math.isfinite(value)", "type(value) is float"
    ),
)


def survives(mutant: Mutant, copy: Path) -> bool:
    """Whether its tests stay green."""
    path = copy / mutant.file
    source = path.read_text()
    if source.count(mutant.before) != 1:
        raise SystemExit(
            f"{mutant.name}: what it changes stands {source.count(mutant.before)} times in {mutant.file}."
        )
    path.write_text(source.replace(mutant.before, mutant.after))
    try:
        return passes(mutant.file, copy)
    finally:
        path.write_text(source)


def passes(file: str, copy: Path) -> bool:
    """Whether the tests of that file of the product are green in the copy."""
    command = [sys.executable, "-m", "pytest", "-n0", "-x", "-q", "-p", "no:cacheprovider", *TESTS[file].split()]
    environment = {**os.environ, "PYTHONPATH": str(copy)}
    try:
        done = subprocess.run(
            command, cwd=copy, env=environment, capture_output=True, timeout=TESTS_TIMEOUT_S, check=False
        )
    except subprocess.TimeoutExpired:
        return False  # a test that waits for ever is red
    return done.returncode == 0


def survivors(chosen: Sequence[Mutant]) -> list[str]:
    """The names of those that no test kills. Raises SystemExit where a killer is red on the whole code, too."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in COPIED:
            source = ROOT / name
            (shutil.copytree if source.is_dir() else shutil.copy)(source, copy / name)
        for file in sorted({mutant.file for mutant in chosen}):
            if not passes(file, copy):
                raise SystemExit(f"{TESTS[file]} fails on unchanged code: nothing is shown by it.")
        alive: list[str] = []
        for mutant in chosen:
            if survives(mutant, copy):
                alive.append(mutant.name)
            sys.stderr.write(f"{mutant.name}: {'SURVIVED' if mutant.name in alive else 'killed'}\n")
    return alive


def main() -> None:
    """Print who survived, as JSON."""
    words = sys.argv[1:]
    chosen = [mutant for mutant in MUTANTS if not words or any(word in mutant.name for word in words)]
    sys.stdout.write(json.dumps({"mutants": len(chosen), "survived": survivors(chosen)}, indent=1) + "\n")


if __name__ == "__main__":
    main()
