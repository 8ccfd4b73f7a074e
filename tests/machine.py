"""How slow the machine is on which the tests run, for the bounds of a test that are times."""

import time

SUMMED_NUMBERS = 3_000_000
USUAL_SUM_S = 0.05  # of processor time, on a computer that is not slow


def slowness() -> float:
    """By how much longer a sum takes than on a usual computer, at least 1; beside others it is so, too."""
    began = time.process_time()
    sum(range(SUMMED_NUMBERS))
    return max((time.process_time() - began) / USUAL_SUM_S, 1.0)
