"""Anything that may happen to a gate, in any order: `python -m tests.benchmarks.state_machine [--seeds 50]`.

[--first 1]. The state machine of the suite (`tests/core/gate/test_gate_state_machine.py`), seed by seed, more than
20,000 steps each.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter

from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.stateful import invariant, run_state_machine_as_test

from tests.core.gate.test_gate_state_machine import AnyOrderOfThings

MAX_STORY_STEPS, STORY_COUNT = 50, 480  # of one story, at most; of one seed


def run(number: int) -> tuple[int, str]:
    """The stories of one seed → steps, and the first violation in words ("": none)."""
    counted = Counter[str]()

    class Counted(AnyOrderOfThings):
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


def main() -> None:
    """Print steps and violations."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--first", type=int, default=1)
    chosen = parser.parse_args()
    steps, violations = 0, list[str]()
    for number in range(chosen.first, chosen.first + chosen.seeds):
        some, violation = run(number)
        steps += some
        violations += [violation] if violation else []
        sys.stderr.write(f"seed {number}: {some} steps {violation}\n")
    sys.stdout.write(json.dumps({"seeds": chosen.seeds, "steps": steps, "violations": violations}, indent=1) + "\n")


if __name__ == "__main__":
    main()
