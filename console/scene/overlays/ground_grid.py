"""The floor's grid: half-metre cells that fade into the distance."""

from viser import SceneApi

from console.scene.drawing.palette import GRID
from core.robots import Profile
from core.snapshot import Snapshot


class GroundGrid:
    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        scene.add_grid(
            "/floor",
            width=60.0,
            height=60.0,
            cell_size=0.5,
            cell_color=GRID,
            cell_thickness=0.4,
            section_size=1.0,
            section_color=GRID,
            section_thickness=0.8,
            fade_distance=28.0,
            fade_strength=1.6,
            shadow_opacity=0.18,
            position=(0.0, 0.0, 0.001),
        )

    def show(self, snapshot: Snapshot) -> None:
        """Nothing to do."""
