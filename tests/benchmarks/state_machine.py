"""Anything that may happen, in any order: `python -m tests.benchmarks.state_machine [gate|control] [--seeds 50]`.

[--first 1]. The state machines of the suite, seed by seed, more than 20,000 steps each: the gate alone, or gate,
dispatcher, lease, words, halts and routes together.
"""

import sys
from collections import Counter
from typing import Annotated

from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.stateful import RuleBasedStateMachine, invariant, run_state_machine_as_test

from tests.benchmarks.command import run_command
from tests.console.control import test_control_state_machine as control
from tests.core.gate import test_gate_state_machine as gate

STATE_MACHINES = {"gate": gate.AnyOrderOfThings, "control": control.AnyOrderOfThings}
MAX_STORY_STEPS, STORY_COUNT = 50, 480  # of one story, at most; of one seed


def run(machine: type[RuleBasedStateMachine], number: int) -> tuple[int, str]:
    """The stories of one seed → steps, and the first violation in words ("": none)."""
    counted = Counter[str]()

    class Counted(machine):  # type: ignore[misc,valid-type]
        @invariant()
        def count(self) -> None:
            counted["steps"] += 1

    options = settings(
        max_examples=STORY_COUNT,
        stateful_step_count=MAX_STORY_STEPS,
        deadline=None,
        database=None,
        phases=(Phase.generate, Phase.shrink),
        suppress_health_check=list(HealthCheck),
    )
    try:
        run_state_machine_as_test(seed(number)(Counted), settings=options)
    except Exception as violation:  # what it found, shrunk
        notes = getattr(violation, "__notes__", [])
        return counted["steps"], "\n".join([f"seed {number}: {type(violation).__name__} {violation}", *notes])
    return counted["steps"], ""


def main(machine: Annotated[str, STATE_MACHINES] = "gate", *, seeds: int = 50, first: int = 1) -> object:
    steps, violations = 0, list[str]()
    for number in range(first, first + seeds):
        some, violation = run(STATE_MACHINES[machine], number)
        steps += some
        violations += [violation] if violation else []
        sys.stderr.write(f"seed {number}: {some} steps {violation}\n")
    return {"machine": machine, "seeds": seeds, "steps": steps, "violations": violations}


if __name__ == "__main__":
    run_command(main)
