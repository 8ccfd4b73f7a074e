"""`beckon run`: the console, by default on the simulated robot."""

import argparse
import gc
import sys
from pathlib import Path
from typing import Any


def add(places: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = places.add_parser("run", help="start the console and open it in the browser")
    parser.add_argument(
        "--robot",
        default="sim:lab",
        metavar="URL",
        help="sim:lab (default), sim:floor, log:FILE for a recording, a real robot (beckon robots) or its robot.toml",
    )
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default 127.0.0.1)")
    parser.add_argument(
        "--allow-host",
        dest="allow_hosts",
        action="append",
        default=[],
        metavar="NAME",
        help="a name or address under which browsers may open the console; may stand several times",
    )
    parser.add_argument("--tls-cert", type=Path, metavar="CERT.pem", help="speak HTTPS with this")
    parser.add_argument("--tls-key", type=Path, metavar="KEY.pem", help="the key of the certificate")
    parser.add_argument("--port", type=int, default=8420, help="0 takes any free port (default 8420)")
    parser.add_argument("--no-browser", dest="open_browser", action="store_false", help="do not open a browser")
    parser.add_argument(
        "--no-auth", action="store_true", help="nobody has to sign in; on 127.0.0.1 with the simulator only"
    )
    parser.add_argument(
        "--token-file",
        type=Path,
        metavar="FILE",
        help="the operator's key, the same over restarts; a new one is written there when there is no such file",
    )
    parser.add_argument(
        "--connect",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="what operators may look at on the page Connect beside the robot they drive: an address, a network or "
        "a name, with or without :PORT, or a folder of recordings; may stand several times (default: nothing)",
    )
    parser.add_argument("--seed", type=int, default=0, help="the simulator's chance")
    parser.add_argument("--data", type=Path, metavar="DIR", help="where history and maps are kept")
    parser.add_argument("--gate-trace", type=Path, metavar="FILE", help="write all that moves the wheels")
    parser.add_argument("--settings", type=Path, metavar="FILE.toml", help="numbers of every algorithm")
    parser.add_argument(
        "--text-files", type=Path, metavar="DIR", help="obey speech.txt (and source.txt) in this folder"
    )
    parser.add_argument(
        "--precedence",
        action="store_true",
        help="run before other programs in the simulator, too, as with a real robot (Linux)",
    )
    parser.add_argument(
        "--log-json", action="store_true", help="log a JSON object a line, to the file and to standard error"
    )
    parser.add_argument("--nobody", action="store_true", help="nobody stands in the simulated room")
    parser.add_argument(
        "--write-text-files",
        type=Path,
        metavar="DIR",
        help="write what the robot's microphones understood into speech.txt and source.txt in this folder",
    )
    parser.add_argument(
        "--foxglove",
        type=int,
        metavar="PORT",
        help="serve the topics of a recording live to Foxglove and Lichtblick on this computer, to look at only",
    )
    parser.add_argument("--fleet", default="", metavar="tls/HOST:PORT", help="join the fleet that listens there")
    parser.add_argument(
        "--name",
        dest="fleet_name",
        default="",
        metavar="NAME",
        help="of the robot in the fleet, as in its certificate",
    )
    parser.add_argument(
        "--fleet-cert",
        type=Path,
        metavar="DIR",
        help="the folder that beckon fleet cert NAME made (default: fleet/NAME in the data folder)",
    )
    parser.set_defaults(run=run)


def run(chosen: argparse.Namespace) -> int:
    """Serve until a signal ends the program."""
    if not chosen.log_json:
        sys.stderr.write(f"Starting {chosen.robot}…\n")  # at once: the imports take seconds
        sys.stderr.flush()
    gc.disable()  # what is imported stays, and looking for garbage in it takes a seventh of the start; on in `serve`
    from console.options import Options
    from console.serve import serve  # takes part of a second to import: only here

    serve(Options.of(chosen))
    return 0
