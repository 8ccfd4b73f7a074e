"""The worker that reads words loads no more than it needs."""

from __future__ import annotations

import subprocess
import sys


def test_the_reader_of_words_does_without_scipy_and_the_pilot_has_what_it_plans_with():
    worker = "import sys, console.speech.transcription_worker, core.speech.whisper.recognizer; "
    pilot = "import sys, core.pilot.pilot; "
    for imports, present in ((worker, False), (pilot, True)):
        script = imports + "print('scipy.sparse.csgraph' in sys.modules)"
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
        assert done.stdout.strip() == str(present)
