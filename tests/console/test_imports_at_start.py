"""The time until the console's address is shown is mostly that of its imports: what may be among them."""

import os
import subprocess
import sys

from tests.machine import slowness

SCIPY_PARTS = ("scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.sparse", "scipy.spatial", "scipy.stats")
LATE_MODULES = (
    *SCIPY_PARTS,
    "markdown_it",
    "matplotlib",
    "onnxruntime",
    "pocketsphinx",
    "sounddevice",
    "torch",
    "zenoh",
)
MOST_MODULES = 1500  # 1,430; 1,854 before scipy came late
MOST_SECONDS = 2.0  # of processor time on a usual computer; it took 1.2


def loaded(module: str) -> tuple[set[str], float]:
    """Import a module in a process of its own → the modules there then, and the seconds that it took."""
    code = f"import gc, sys, time; gc.disable(); import {module}; print(time.process_time(), *sys.modules)"
    told = subprocess.run(
        [sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True, env=dict(os.environ)
    ).stdout.split()
    return set(told[1:]), float(told[0])


def test_the_console_loads_nothing_before_its_address_that_can_come_later() -> None:
    modules, seconds = loaded("console.serve, console.app, console.assembly")
    assert "fastapi" in modules and "numpy" in modules
    assert not modules & set(LATE_MODULES)
    assert len(modules) < MOST_MODULES and seconds < MOST_SECONDS * slowness()


def test_the_robot_is_begun_to_be_opened_before_the_web_stack_is_loaded() -> None:
    modules, _ = loaded("console.serve")
    assert not {name.partition(".")[0] for name in modules} & {"fastapi", "pydantic", "uvicorn", "viser"}


def test_the_driver_and_the_workers_do_without_scipy_and_the_web() -> None:
    for module in ("core.robots.process", "console.workers.process"):
        modules, _ = loaded(module)
        assert not {name.partition(".")[0] for name in modules} & {"scipy", "fastapi", "viser", "pydantic"}


def test_the_driver_of_a_robot_brings_no_reader_of_recordings() -> None:
    modules, _ = loaded("core.robots.process, core.simulation.robot")
    assert not {name.partition(".")[0] for name in modules} & {"lz4", "rosbags", "ruamel", "sqlite3", "zstandard"}


def test_what_reads_words_brings_nothing_that_fetches_a_model() -> None:
    modules, _ = loaded("console.workers.process, console.speech.transcription_worker")
    assert not modules & {"http.client", "urllib.request", "ruamel.yaml", "rosbags"}
