"""The options of `beckon run` and `beckon fleet`, each declared once: its default and its meaning."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Self, get_args


def option(default: Any, meaning: str, metavar: str | None = None, flag: str = "") -> Any:
    """A field that the command line sets; `flag`: how it is written there, where not as its name."""
    return field(default=default, metadata={"help": meaning, "metavar": metavar, "flag": flag})


@dataclass(frozen=True)
class Options:
    """The options of `beckon run`."""

    robot: str = option(
        "sim:lab",
        "sim:lab (default), sim:floor, log:FILE for a recording, a real robot (beckon robots) or its robot.toml",
        "URL",
    )
    host: str = option("127.0.0.1", "address to listen on (default 127.0.0.1)")
    allow_hosts: Sequence[str] = option(
        (),
        "a name or address under which browsers may open the console; may stand several times",
        "NAME",
        "--allow-host",
    )
    tls_cert: Path | None = option(None, "speak HTTPS with this", "CERT.pem")
    tls_key: Path | None = option(None, "the key of the certificate", "KEY.pem")
    port: int = option(8420, "0 takes any free port (default 8420)")
    open_browser: bool = option(True, "do not open a browser", flag="--no-browser")
    no_auth: bool = option(False, "nobody has to sign in; on 127.0.0.1 with the simulator only")
    token_file: Path | None = option(
        None,
        "the operator's key, the same over restarts; a new one is written there when there is no such file",
        "FILE",
    )
    connect: Sequence[str] = option(
        (),
        "what operators may look at on the page Connect beside the robot they drive: an address, a network or "
        "a name, with or without :PORT, or a folder of recordings; may stand several times (default: nothing)",
        "ADDRESS",
    )
    seed: int = option(0, "the simulator's chance")
    data: Path | None = option(None, "where history and maps are kept", "DIR")
    gate_trace: Path | None = option(None, "write all that moves the wheels", "FILE")
    settings: Path | None = option(None, "numbers of every algorithm", "FILE.toml")
    text_files: Path | None = option(None, "obey speech.txt (and source.txt) in this folder", "DIR")
    precedence: bool = option(False, "run before other programs in the simulator, too, as with a real robot (Linux)")
    log_json: bool = option(False, "log a JSON object a line, to the file and to standard error")
    nobody: bool = option(False, "nobody stands in the simulated room")
    write_text_files: Path | None = option(
        None, "write what the robot's microphones understood into speech.txt and source.txt in this folder", "DIR"
    )
    foxglove: int | None = option(
        None,
        "serve the topics of a recording live to Foxglove and Lichtblick on this computer, to look at only",
        "PORT",
    )
    fleet: str = option("", "join the fleet that listens there", "tls/HOST:PORT")
    fleet_name: str = option("", "of the robot in the fleet, as in its certificate", "NAME", "--name")
    fleet_cert: Path | None = option(
        None, "the folder that beckon fleet cert NAME made (default: fleet/NAME in the data folder)", "DIR"
    )
    log: Path | None = None  # None: console.log in the data folder

    @classmethod
    def of(cls, chosen: argparse.Namespace) -> Self:
        """The options as the command line has them; what it does not ask for stays as it is."""
        return cls(**{one.name: getattr(chosen, one.name) for one in fields(cls) if one.name in chosen})


def add_options(parser: argparse.ArgumentParser, meanings: Mapping[str, str] | None = None) -> None:
    """Give a subcommand all options, or those with a meaning; "": the declared one."""
    for one in fields(Options):
        if one.metadata and (meanings is None or one.name in meanings):
            how: dict[str, Any] = {"dest": one.name, "default": one.default, **one.metadata}
            how["help"] = (meanings or {}).get(one.name) or how["help"]
            if isinstance(one.default, bool):
                del how["metavar"]
                how["action"] = "store_false" if one.default else "store_true"
            elif one.default == ():
                how |= {"action": "append", "default": []}
            else:
                how["type"] = next(iter(get_args(one.type)), one.type)
            parser.add_argument(how.pop("flag") or f"--{one.name.replace('_', '-')}", **how)
