"""`beckon fleet`: many robots on one page; `beckon fleet cert NAME`: a robot's certificate."""

import argparse
import sys
import time
from typing import Any

from console.cli.answer import add_command, add_out, answer, tell, write, write_json
from console.declared_options import Options, add_options

MEANINGS = {
    "port": "of the page; 0 takes any free port (default 8430)",
    "host": "address of the page (default 127.0.0.1)",
    "allow_hosts": "a name or address by which browsers and robots may find this computer; may stand several times",
    "tls_cert": "",
    "tls_key": "",
    "open_browser": "",
    "data": "where the fleet keeps its files",
}
"""Of the options that a fleet's page shares with a console."""


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "fleet", run, "many robots: one page, one STOP ALL", json=False)
    parser.add_argument(
        "--listen",
        default="tls/0.0.0.0:7447",
        metavar="tls/ADDRESS:PORT",
        help="where robots join (default tls/0.0.0.0:7447)",
    )
    add_options(parser, MEANINGS)
    parser.set_defaults(port=8430)
    doings = parser.add_subparsers(dest="doing", metavar="DOING")
    making = add_command(doings, "cert", make_certificate, "make a certificate by which a robot joins")
    making.add_argument("name", metavar="NAME", help="of the robot: letters, digits, - and _")
    making.add_argument("--viewer", action="store_true", help="for a program that only reads what robots say")
    making.add_argument("--days", type=int, default=825, help="for which it is good (default 825)")
    making.add_argument("--withdraw", action="store_true", help="make none: let the one of this name in no more")
    add_out(making, "folder of its files (default: fleet/NAME in the data folder)")
    setting = add_command(
        doings, "role", set_role, "what a person may do at one robot, where it is not as everywhere"
    )
    setting.add_argument("person", metavar="PERSON", help="the name of their key or link")
    setting.add_argument("robot", metavar="ROBOT")
    setting.add_argument("role", choices=("none", "viewer", "operator", "admin"))
    for one in (making, setting):
        add_options(one, {"data": MEANINGS["data"]})


def run(chosen: argparse.Namespace) -> int:
    sys.stderr.write("Starting the fleet…\n")
    sys.stderr.flush()
    from console.fleet_server.serve import FleetOptions, serve_fleet

    serve_fleet(FleetOptions(Options.of(chosen), chosen.listen))
    return 0


def make_certificate(chosen: argparse.Namespace) -> int:
    """Make, or withdraw, one. Raises BadInput, Unavailable, Unwritable."""
    from console.data_folder import home_folder, prepare
    from console.fleet.authority import Authority

    home = home_folder(chosen.data)
    prepare(home)
    authority = Authority(home / "fleet")
    if chosen.withdraw:
        authority.withdraw(chosen.name)
        tell(f"{chosen.name} is let in no more; a running fleet cuts it off within a second.")
        return answer(chosen, {"name": chosen.name, "withdrawn": True})
    out = chosen.out or home / "fleet" / chosen.name
    kind = "viewer" if chosen.viewer else "robot"
    made = authority.issue(chosen.name, out, kind=kind, days=chosen.days)
    if chosen.json:
        files = {each: str(out / f"{each}.pem") for each in ("authority", "certificate", "key")}
        write_json({"name": made.name, "kind": made.kind, "end_s": made.end_s, "files": files})
        return 0
    write(str(out))
    end = time.strftime("%Y-%m-%d", time.localtime(made.end_s))
    tell(f"The certificate of {made.name} is good until {end}. Keep the folder secret; copy it to the robot, then:")
    tell(f"beckon run --fleet tls/HOST:7447 --name {made.name} --fleet-cert {out}")
    return 0


def set_role(chosen: argparse.Namespace) -> int:
    """Set it; a running fleet takes it at once. Raises BadInput."""
    from console.cli.token import tidy
    from console.data_folder import home_folder, prepare
    from console.fleet_server.runtime import FleetRoles

    home, person = home_folder(chosen.data) / "fleet", tidy(chosen.person)  # as their key has it
    prepare(home)
    role = None if chosen.role == "none" else chosen.role
    FleetRoles(home).set(person, chosen.robot, role)
    row = {"person": person, "robot": chosen.robot, "role": role}
    return answer(chosen, row, f"{person} is {chosen.role} at {chosen.robot}.")
