"""Edges found in bad pictures: `python -m tests.benchmarks.picture_quality [--poses 24] [--out FILE.json]`.

Pictures of both simulated worlds from random places, spoiled by low light, noise, defocus and turning. What is there
to be found is told by the same picture drawn without noise in full light: edges that the detector finds in it count
as true, those that it finds at a more than twice lower threshold as not false, and beside them, by geometry alone,
the corners of the walls. Each condition with and without the preparation that the picture's quality calls for; the
pictures are the same. Last, the processor time of judging and of finding.
"""

import json
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from scipy.optimize import linear_sum_assignment

from core.geometry import Pose, wrap
from core.message import Array
from core.perception.image_quality.quality import PictureSettings, judge
from core.perception.landmarks.edges import NOTHING, EdgeSettings, find_edges
from core.perception.landmarks.level_view import level_view
from core.sensors import Camera, Image
from core.simulation.camera import SimulatedCamera
from core.simulation.world import World, cast, world_named
from tests.benchmarks.command import print_row, run_command

CAMERA = Camera()
NEAR = math.radians(1.0)  # an edge closer than this to a true one is that one
HALF = math.atan(0.9 * 0.5 * CAMERA.model.width / CAMERA.model.fx)  # [rad] of the field that counts
EXPOSURE = 0.02  # [s]
LENIENT = replace(EdgeSettings(), canny_low=6.0, canny_high=14.0, length=0.14)


@dataclass(frozen=True)
class Condition:
    """How the pictures are spoiled."""

    light: float = 1.0
    snr: float = 42.0  # [dB]
    defocus: float = 0.0  # [pixel]
    smear: float = 0.0  # [pixel] length of the motion's blur

    def __str__(self) -> str:
        return f"light {self.light:<4g} {self.snr:g} dB  defocus {self.defocus:<3g} smear {self.smear:<3g}"


CONDITIONS = (
    *(Condition(light=light) for light in (1.0, 0.5, 0.25, 0.1, 0.05)),
    *(Condition(snr=snr) for snr in (30.0, 20.0, 15.0)),
    *(Condition(defocus=width) for width in (1.0, 2.0, 3.0)),
    *(Condition(smear=length) for length in (3.0, 6.0, 10.0)),
    *(Condition(light=0.5, snr=30.0), Condition(light=0.25, snr=30.0), Condition(snr=30.0, defocus=2.0)),
    Condition(light=0.25, snr=36.0, smear=5.0),
)


@dataclass(frozen=True)
class Place:
    """Somewhere to look from, and what is there to be found: bearings [rad]."""

    world: World
    pose: Pose
    true: Array
    possible: Array
    corners: Array


def places(number: int) -> list[Place]:
    """Free poses in both worlds, the same every time."""
    rng, found = np.random.default_rng(4), list[Place]()
    for name in ("lab", "floor"):
        world = world_named(name)
        clean = SimulatedCamera(CAMERA, world, rng, snr=100.0)
        bounds = world.bounds
        before = len(found)
        while len(found) - before < number // 2:
            x, y = rng.uniform((bounds.x0, bounds.y0), (bounds.x1, bounds.y1))
            if not world.free(float(x), float(y), 0.4):
                continue
            pose = Pose(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
            picture = clean.take(world, 0.0, pose)
            found.append(
                Place(world, pose, bearings(picture), bearings(picture, LENIENT), corners_in_view(world, pose))
            )
    return found


def bearings(picture: Image, settings: EdgeSettings | None = None, **more: Any) -> Array:
    """Bearings [rad] of the edges in a picture, away from its rim."""
    seen = np.array([edge.bearing for edge in find_edges(picture, CAMERA, settings, **more)])
    return seen[np.abs(seen) < HALF] if len(seen) else seen


def corners_in_view(world: World, pose: Pose) -> Array:
    """Bearings [rad] of the walls' corners that the camera sees between 0.5 and 4 m, by geometry alone."""
    eye = pose.apply(CAMERA.mounting.translation[None, :2])[0]
    rays = world.walls[:, :2] - eye
    away = np.hypot(*rays.T)
    hits = cast(eye, rays * (1 - 0.01 / away)[:, None], world.surfaces(CAMERA.mounting.translation[2]))
    bearing = np.array([wrap(math.atan2(y, x) - pose.heading) for x, y in rays.tolist()])
    return bearing[(hits.distance > 1.0) & (away > 0.5) & (away < 4.0) & (np.abs(bearing) < 0.85 * HALF)]


def paired(seen: Array, true: Array) -> Array:
    """Errors [rad] with which the true bearings (N,) were seen, one to one; NaN for those that were not."""
    errors = np.full(len(true), np.nan)
    if len(seen) and len(true):
        off = np.array([[wrap(a - b) for b in true.tolist()] for a in seen.tolist()])
        rows, columns = linear_sum_assignment(np.minimum(np.abs(off), NEAR))
        chosen = off[rows, columns]
        errors[columns] = np.where(np.abs(chosen) < NEAR, chosen, np.nan)
    return errors


def met(errors: Array) -> int:
    """How many were seen."""
    return int(np.isfinite(errors).sum())


def figures(sites: list[Place], condition: Condition, prepared: bool) -> dict[str, Any]:
    """Shares found and false, error of the bearings, for one condition."""
    chance = np.random.default_rng(1)
    rate = condition.smear / CAMERA.model.fx / EXPOSURE
    cameras = {
        site.world.name: SimulatedCamera(
            CAMERA,
            site.world,
            chance,
            light=condition.light,
            snr=condition.snr,
            exposure=EXPOSURE,
            defocus=condition.defocus,
        )
        for site in sites
    }
    errors: list[Array] = []
    false = corners = corners_met = 0
    changed, noise, blur, states = 0, list[float](), list[float](), dict[str, int]()
    for site in sites:
        picture = cameras[site.world.name].take(site.world, 0.0, site.pose, rate)
        quality = judge(picture, turn_rate=rate, settings=PictureSettings(prepare=prepared))
        seen = bearings(picture, preparation=quality.preparation if prepared else NOTHING)
        errors.append(paired(seen, site.true))
        false += len(seen) - met(paired(seen, site.possible))
        corners, corners_met = corners + len(site.corners), corners_met + met(paired(seen, site.corners))
        changed += not quality.preparation.idle
        noise.append(quality.noise)
        if quality.blur.across is not None:
            blur.append(quality.blur.across)
        states[quality.state] = states.get(quality.state, 0) + 1
    off = np.concatenate(errors)
    return {
        "found": met(off) / len(off),
        "corners": corners_met / max(corners, 1),
        "false_per_picture": false / len(sites),
        "errors": off,
        "prepared_share": changed / len(sites),
        "noise_median": float(np.median(noise)),
        "blur_median_px": float(np.median(blur)) if blur else None,
        "states": states,
    }


def times(sites: list[Place]) -> dict[str, float]:
    """Median processor time [ms] of judging a picture, of preparing it, and of finding edges in it either way."""
    site = sites[0]
    chance = np.random.default_rng(2)
    bad = SimulatedCamera(CAMERA, site.world, chance, light=0.25, snr=30.0).take(site.world, 0.0, site.pose)
    clean = SimulatedCamera(CAMERA, site.world, chance).take(site.world, 0.0, site.pose)
    wanted = judge(bad).preparation
    level = level_view(CAMERA).warp(wanted.grey(bad.pixels))
    tasks: dict[str, Callable[[], object]] = {
        "judge": lambda: judge(bad),
        "light": lambda: wanted.grey(bad.pixels),
        "smooth": lambda: cv2.GaussianBlur(level, (0, 0), sigmaX=wanted.across, sigmaY=wanted.along),
        "edges_clean": lambda: find_edges(clean, CAMERA),
        "edges_prepared": lambda: find_edges(bad, CAMERA, preparation=wanted),
    }
    spent: dict[str, float] = {}
    for name, task in tasks.items():
        runs: list[float] = []
        for _ in range(60):
            begun = time.process_time()
            task()
            runs.append(time.process_time() - begun)
        spent[f"{name}_ms"] = 1000 * float(np.median(runs))
    return spent


def main(*, poses: int = 24, out: Path | None = None) -> None:
    cv2.setNumThreads(1)
    sites = places(poses)
    print_row(f"{'':46}    found   corners  false/pic  bearing deg   (as it comes | prepared)   noise  blur  states")
    rows: list[dict[str, Any]] = []
    for condition in CONDITIONS:
        plain, done = (figures(sites, condition, prepared) for prepared in (False, True))
        both = np.column_stack((plain.pop("errors"), done.pop("errors")))
        both = both[np.isfinite(both).all(axis=1)]  # errors are compared on the edges that were found either way
        for one, errors in zip((plain, done), both.T, strict=True):
            one["bearing_rms_deg"] = math.degrees(float(np.sqrt(np.mean(errors**2)))) if len(errors) else None
        rows.append({"condition": condition.__dict__, "as_it_comes": plain, "prepared": done})
        pairs = [f"{condition!s:46}"]
        pairs += [f"{plain[key]:.2f} | {done[key]:.2f}" for key in ("found", "corners", "false_per_picture")]
        pairs.append(
            " | ".join(
                "  - " if one["bearing_rms_deg"] is None else f"{one['bearing_rms_deg']:.3f}" for one in (plain, done)
            )
        )
        width = done["blur_median_px"]
        pairs.append(f"{done['noise_median']:.1f}  {'-' if width is None else f'{width:.1f}'}  {done['states']}")
        print_row("  ".join(pairs))
    spent = times(sites)
    print_row(", ".join(f"{name} {value:.2f}" for name, value in spent.items()))
    if out is not None:
        out.write_text(json.dumps({"poses": poses, "rows": rows, **spent}, indent=1))


if __name__ == "__main__":
    run_command(main)
