"""Whether words ever move the robot late, in many stories: `python -m tests.benchmarks.late_words [LAST [FIRST]]`.

Each story is nine seconds of people who speak at two ears, write, type, stop, drive by hand, take over and
close pages, while the reader of words is slow or frozen. Time is only counted; see `tests.stories.words_in_time`.
"""

import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.benchmarks.command import print_row, run_command
from tests.stories.words_in_time import told_story


def main(last: int = 100_000, first: int = 0) -> int:
    moved: Counter[str] = Counter()
    wrong, begun = 0, time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        for number in range(first, last):
            seen = told_story(number, Path(folder))
            moved += Counter(seen.uttered[words].source for _, words in seen.motions)
            wrong += len(seen.wrong)
            for sentence in seen.wrong:
                print_row(f"story {number}: {sentence}")
            if (number + 1) % 5000 == 0:
                print_row(f"{number + 1 - first} stories, {wrong} violations")
    spent = time.perf_counter() - begun
    print_row(f"{last - first} stories, {wrong} violations, motions by {dict(moved)}, {spent:.0f} s")
    return 1 if wrong else 0


if __name__ == "__main__":
    run_command(main)
