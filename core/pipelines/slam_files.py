"""The files an offline run leaves: trajectory (TUM), landmarks (CSV), map (Nav2, PNG), and its report (HTML)."""

import math
from collections.abc import Iterable
from pathlib import Path

from core.files import save_all
from core.geometry import Pose
from core.pipelines.nav2_map import nav2_map
from core.pipelines.slam_report import map_png
from core.pipelines.slam_result import SlamResult
from core.slam.estimate import Landmark


def trajectory_tum(stamps: Iterable[float], poses: Iterable[Pose]) -> str:
    """Stamps [s] and poses → lines `t tx ty tz qx qy qz qw`, eight columns, single spaces."""
    return "".join(
        f"{stamp:.6f} {pose.x:.6f} {pose.y:.6f} 0 0 0 "
        f"{math.sin(pose.heading / 2):.9f} {math.cos(pose.heading / 2):.9f}\n"
        for stamp, pose in zip(stamps, poses, strict=True)
    )


def landmarks_csv(landmarks: Iterable[Landmark]) -> str:
    """The table of landmarks, one a line."""
    lines = ["id,x_m,y_m,var_x_m2,cov_xy_m2,var_y_m2,hits,misses,kind"]
    for mark in landmarks:
        (x, y), ((xx, xy), (_, yy)) = mark.position.tolist(), mark.covariance.tolist()
        lines.append(f"{mark.id},{x:.6f},{y:.6f},{xx:.9g},{xy:.9g},{yy:.9g},{mark.hits},{mark.misses},{mark.kind}")
    return "\n".join(lines) + "\n"


def save(folder: Path, run: SlamResult, report: str) -> dict[str, str | None]:
    """Write everything into `folder` → what lies where; without a grid there is no map. Raises Unwritable."""
    contents: dict[str, tuple[str, bytes]] = {
        "trajectory_tum": ("trajectory.tum", trajectory_tum(run.stamps, run.poses).encode()),
        "landmarks_csv": ("landmarks.csv", landmarks_csv(run.landmarks).encode()),
        "report_html": ("report.html", report.encode()),
    }
    if run.grid is not None:
        text, picture = nav2_map(run.grid, "map.pgm")
        contents |= {
            "map_yaml": ("map.yaml", text.encode()),
            "map_pgm": ("map.pgm", picture),
            "map_png": ("map.png", map_png(run.grid)),
        }
    return {"map_yaml": None, **save_all(folder, contents)}
