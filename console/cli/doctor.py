"""`beckon doctor`: what is installed, what is missing, and the command that installs it."""

from __future__ import annotations

import argparse
import shutil
import socket
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from console.cli.answer import add_json, tell, write, write_json
from console.home import home_folder
from core.message import message

NEEDED = (
    "viser",
    "numpy",
    "scipy",
    "opencv-python-headless",
    "fastapi",
    "uvicorn",
    "websockets",
    "msgspec",
    "mcap",
    "rosbags",
)
PORT = 8420


@message
class Finding:
    """One line of the examination."""

    name: str
    good: bool
    found: str
    needed: bool = True  # False: Beckon runs without it
    remedy: str = ""


def add(places: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = places.add_parser(
        "doctor", help="what is installed, what is missing, what to do"
    )
    parser.add_argument("--self-test", action="store_true", help="drive the simulated robot for a minute and measure")
    add_json(parser)
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace) -> int:
    """Exit code 1 when something needed is missing or the self-test fails."""
    findings = [*examine()]
    if chosen.self_test:
        from console.cli.self_test import self_test  # the whole robot: only when it is asked for

        tell("The self-test drives the simulated robot; this takes about a minute.")
        findings += [Finding(name=name, good=good, found=found) for name, good, found in self_test()]
    well = all(finding.good or not finding.needed for finding in findings)
    if chosen.json:
        write_json(
            {
                "ok": well,
                "findings": [
                    {
                        "name": finding.name,
                        "ok": finding.good,
                        "needed": finding.needed,
                        "found": finding.found,
                        "remedy": "" if finding.good else finding.remedy,
                    }
                    for finding in findings
                ],
            }
        )
    else:
        for finding in findings:
            mark = "ok  " if finding.good else ("MISSING" if finding.needed else "absent")
            write(f"{mark:8}{finding.name:26}{finding.found}")
            if not finding.good and finding.remedy:
                write(f"        → {finding.remedy}")
        write("All that is needed is here." if well else "Something that is needed is missing; see the arrows above.")
    return 0 if well else 1


def examine() -> list[Finding]:
    """Look at everything once."""
    return [python(), *map(package, NEEDED), pipe(), port(), home(), browser()]


def python() -> Finding:
    """The interpreter."""
    running = ".".join(map(str, sys.version_info[:3]))
    return Finding(
        name="Python",
        good=sys.version_info >= (3, 11),
        found=running,
        remedy="install Python 3.11 or newer",
    )


def package(name: str) -> Finding:
    """One of the packages Beckon needs."""
    try:
        return Finding(name=name, good=True, found=version(name))
    except PackageNotFoundError:
        return Finding(name=name, good=False, found="not installed", remedy=f"pip install {name}")


def pipe() -> Finding:
    """The kind of pipe between console and gate."""
    good = hasattr(socket, "SOCK_SEQPACKET") and sys.platform == "linux"
    return Finding(
        name="message pipes",
        good=good,
        needed=False,
        found="SOCK_SEQPACKET" if good else "datagrams: a dead console is noticed by its silence only",
        remedy="run the robot's side on Linux",
    )


def port() -> Finding:
    """The port of the console."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", PORT))
        except OSError:
            return Finding(
                name=f"port {PORT}",
                good=False,
                needed=False,
                found="in use",
                remedy="another console may be running; or choose one: beckon --port 0",
            )
    return Finding(name=f"port {PORT}", good=True, found="free")


def home() -> Finding:
    """Where Beckon keeps its things."""
    folder = home_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".writable"
        probe.write_text("")
        probe.unlink()
    except OSError as trouble:
        return Finding(
            name="data folder",
            good=False,
            found=f"{folder}: {trouble.strerror}",
            remedy="set BECKON_HOME to a folder that you may write to",
        )
    return Finding(name="data folder", good=True, found=str(folder))


def browser() -> Finding:
    """A browser for the project's own tests."""
    names = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
    where = next((found for found in map(shutil.which, names) if found), None)
    return Finding(
        name="Chromium (tests only)",
        good=where is not None,
        needed=False,
        found=str(Path(where)) if where else "not found",
        remedy="Debian: apt install chromium · elsewhere: playwright install chromium",
    )
