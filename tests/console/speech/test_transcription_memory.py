"""The processes beside the console load no more than they need."""

import subprocess
import sys


def test_the_reader_of_words_and_drivers_do_without_scipy_and_the_pilot_has_what_it_plans_with():
    planner = "scipy.sparse.csgraph"
    worker = "console.speech.transcription_worker, core.speech.whisper.recognizer"
    drivers = "core.robots.process, core.simulation.robot, core.robots.foxglove, core.robots.zenoh_link"
    for imports, module, present in (
        (worker, planner, False),
        (drivers, "scipy", False),
        ("console.robot.pilot_thread as thread; thread.load_mathematics()", planner, True),
    ):
        script = f"import sys, {imports}; print({module!r} in sys.modules)"
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
        assert done.stdout.strip() == str(present)
