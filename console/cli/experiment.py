"""`beckon experiment`: compute one figure or table again, all of them, or one for every setting of a grid."""

import argparse
import math
import sys
from pathlib import Path
from typing import Any

from console.cli.answer import (
    ShownProgress,
    add_command,
    add_out,
    answer,
    number,
    progress,
    tell,
    whole_number,
    write,
    write_json,
)
from core.errors import BadSettings, Unavailable
from core.experiments import EXPERIMENTS
from core.experiments.campaign import REPORT_EVERY_S, Campaign
from core.experiments.result import BoardPoseFigures, ExperimentResult, as_text
from core.files import save

MOST_RUNS = 100_000
MAX_WORKERS = 1024
SWEEP, ALL = "sweep", "all"
COURSE_OPTIONS = ("data", "noise", "field", "still", "ids", "through", "settings")
LEAST_NOISE, MOST_NOISE = 0.05, 20.0
TERMINAL_EVERY_S = 0.2  # of a progress that changes in its line
runs = whole_number(1, MOST_RUNS, f"Give a whole number of runs between 1 and {MOST_RUNS}.")
workers = whole_number(1, MAX_WORKERS, f"Give a whole number of processes between 1 and {MAX_WORKERS}.")
seed = whole_number(0, 10**18 - 1, "A seed is a whole number from 0 on, of at most 18 digits.")
noise = number(LEAST_NOISE, MOST_NOISE, f"Give a number between {LEAST_NOISE:g} and {MOST_NOISE:g}.")


def add(subcommands: Any) -> None:
    parser = add_command(subcommands, "experiment", run, "compute a figure or a table again")
    names = sorted(EXPERIMENTS)
    parser.add_argument(
        "name",
        choices=[*names, SWEEP, ALL],
        metavar="NAME",
        help=", ".join(names) + "; or sweep NAME; or all, with the runs and seeds of the documentation",
    )
    parser.add_argument(
        "named", nargs="*", type=experiment, metavar="NAME", help="sweep: the experiment; all: only these"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="SECTION.SETTING=A,B,…",
        help="sweep: a setting and its values, as ekf.gate=3,5,9; with several of them all combinations",
    )
    parser.add_argument("--runs", type=runs, help="how often (the experiment's own number)")
    parser.add_argument("--seed", type=seed, help="the same seed gives the same answer (default 0)")
    add_out(parser, "where files go; every run's figures as soon as it is done")
    parser.add_argument(
        "--workers",
        type=workers,
        metavar="N",
        help="processes on this computer, or of the cluster at the most; the answer does not depend on it",
    )
    parser.add_argument("--cluster", default="", metavar="tcp://HOST:8786", help="scheduler of a dask cluster")
    parser.add_argument("--resume", action="store_true", help="go on with the runs that lack in --out")
    _add_course_options(parser)


def _add_course_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of some experiments beyond runs, seed and folder: above all `dead-reckoning-vs-slam`."""
    own = parser.add_argument_group("dead-reckoning-vs-slam")
    own.add_argument("--data", type=Path, metavar="FILE.npz", help="frozen draws instead of the simulator")
    own.add_argument("--noise", type=noise, metavar="X", help="all of eq. 43 X times as large")
    own.add_argument("--field", choices=("laser", "camera"), help="what is seen: 240 degrees (default), or 56")
    own.add_argument("--still", action="store_true", default=None, help="ten frames at rest before the first move")
    own.add_argument(
        "--ids", choices=("given", "hidden"), help="given: the filter knows the corners' names; hidden: it does not"
    )
    own.add_argument(
        "--through",
        choices=("drawn", "sensors"),
        help="sightings drawn about the true corners (default), or made out by the whole robot in sim:lab",
    )
    own.add_argument(
        "--settings",
        type=Path,
        metavar="FILE.toml",
        help="noise, gates and the filter's form, [ekf] mode; without it the paper's form (others take it too)",
    )
    parser.set_defaults(wrong=parser.error)


def chosen_options(chosen: argparse.Namespace, name: str) -> dict[str, object]:
    """Return the options beyond the usual; exit with wrong usage where the experiment does not know them."""
    asked: dict[str, object] = {
        key: getattr(chosen, key) for key in COURSE_OPTIONS if getattr(chosen, key) is not None
    }
    strange = [f"--{key}" for key in asked if key not in EXPERIMENTS[name].options]
    if strange:
        chosen.wrong(f"{name} does not take {', '.join(strange)}")
    if "settings" in asked:
        from core.settings import load  # scipy and OpenCV take a moment: only where they are needed

        asked["settings"] = load(chosen.settings)
    return asked


def run(chosen: argparse.Namespace) -> int:
    if chosen.resume and chosen.out is None:
        raise BadSettings("--resume goes on with the runs in a folder; give it with --out DIR.")
    if chosen.name == ALL and not chosen.set:
        return run_all(chosen)
    if len(chosen.named) != (chosen.name == SWEEP) or (chosen.name != SWEEP and chosen.set):
        raise BadSettings("A sweep is `beckon experiment sweep NAME --set SECTION.SETTING=A,B,…`.")
    name = chosen.named[0] if chosen.name == SWEEP else chosen.name
    with progress() as say:
        result = carried_out(chosen, name, chosen.seed or 0, chosen.out, say)
    return answer(chosen, result, as_text(result))


def carried_out(
    chosen: argparse.Namespace, name: str, seed: int, out: Path | None, say: ShownProgress
) -> ExperimentResult:
    """One experiment, or its sweep, with its files in `out`."""
    options = {"runs": chosen.runs, **chosen_options(chosen, name)}
    campaign = Campaign(
        name if chosen.name != SWEEP else f"{SWEEP}-{name}",
        seed,
        out,
        tell,
        chosen.workers,
        chosen.cluster,
        chosen.resume,
        say,
        TERMINAL_EVERY_S if sys.stderr.isatty() else REPORT_EVERY_S,
    )
    if chosen.name == SWEEP:
        from core.experiments.sweep import sweep  # all settings: they take a moment

        result = campaign.carry_out(sweep(name, chosen.set, {**options, "seed": seed}))
    else:
        result = EXPERIMENTS[name].carry_out(campaign, options)
    if out is not None and "boards" in result:
        result["files"]["figure_15_scene"] = board_scene(result["boards"], out)
    return result


def run_all(chosen: argparse.Namespace) -> int:
    """Run all experiments, or those that are named, each into its folder; store what the documentation takes."""
    from console.published import compact, origin  # numpy and OpenCV take a moment

    if chosen.out is None:
        raise BadSettings("All experiments write their figures into a folder; give it with --out DIR.")
    made_by = origin()
    done: dict[str, dict[str, Any]] = {}
    missing: dict[str, str] = {}
    for name in chosen.named or sorted(EXPERIMENTS):
        seed = EXPERIMENTS[name].about.seed if chosen.seed is None else chosen.seed
        tell(f"{name}, seed {seed}")
        try:
            with progress() as say:
                result = carried_out(chosen, name, seed, chosen.out / name, say)
        except Unavailable as missed:
            missing[name] = str(missed)
            tell(str(missed))
            continue
        kept = compact({**result, "runs": chosen.runs or EXPERIMENTS[name].about.runs}, made_by)
        done[name] = {
            "seed": seed,
            "seconds": result.get("seconds", 0.0),
            "file": save(chosen.out / f"{name}.json", kept),
        }
    if chosen.json:
        write_json({"made_by": made_by, "experiments": done, "missing": missing})
    else:
        write("\n".join(f"{name:24}{one['seconds']:9.1f} s  {one['file']}" for name, one in done.items()))
    return 1 if missing else 0


def board_scene(boards: list[BoardPoseFigures], out: Path) -> str:
    """Figure 15 as a scene to be turned, in one file → its path. Raises Unavailable."""
    from console.scene.calibration_boards import boards_html  # viser takes a moment: only where it is needed
    from core.experiments.camera_table import BOARD
    from core.optics import TABLE_3

    angle = 2 * math.atan(TABLE_3.height / 2 / TABLE_3.fy)
    page = boards_html(boards, BOARD, angle, TABLE_3.width / TABLE_3.height)
    return save(out / "figure_15.html", page.encode())


def experiment(text: str) -> str:
    """'tour' → the same, where there is such an experiment."""
    if text not in EXPERIMENTS:
        raise argparse.ArgumentTypeError(
            f"There is no experiment {text[:40]}; there are {', '.join(sorted(EXPERIMENTS))}."
        )
    return text
