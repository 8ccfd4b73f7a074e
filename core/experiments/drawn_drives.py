"""Drives whose sightings are drawn about the true corners: the paper's simulation."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

from core.errors import BadInput
from core.experiments.course_draws import Draws, Field, frozen
from core.experiments.course_traces import Trace, mapped, reckoned
from core.experiments.drives import FIGURED, PLAIN, DriveSetup, DriveSurroundings
from core.experiments.paper_course import UPDATES_PER_SIGHTING
from core.recording import Ids
from core.settings import Settings
from core.slam.ekf_slam import EkfSettings


@dataclass(frozen=True)
class DrawnDrives:
    """Draws, and the filter they go through; its other form runs next to it."""

    draws: Draws
    ekf: EkfSettings
    still: bool

    @property
    def rows(self) -> tuple[str, ...]:
        """Dead reckoning, the figure's filter, its other form."""
        return PLAIN, *self._forms

    @property
    def room(self) -> DriveSurroundings:
        """The corners."""
        return DriveSurroundings(corners=self.draws.run(0).landmarks)

    @property
    def setup(self) -> DriveSetup:
        """The set-up, ready for JSON."""
        motion, (far, aside) = self.draws.motion, self.draws.sighting_noise
        return {
            "through": "drawn",
            "data": self.draws.data.name if self.draws.data else None,
            "mode": self.ekf.mode,
            "still_start": self.still,
            "ids": self.draws.ids,
            "field": self.draws.field,
            "speed_m_s": motion.cruise,
            "wheelbase_m": motion.wheelbase,
            "speed_sd_m_s": motion.speed_sd,
            "steer_sd_deg": math.degrees(motion.steer_sd),
            "range_sd_m": far,
            "bearing_sd_deg": math.degrees(aside),
        }

    @property
    def words(self) -> str:
        """The set-up in a line."""
        motion, (far, aside) = self.draws.motion, self.draws.sighting_noise
        parts = (
            f"{motion.cruise:g} m/s, controls {1 / motion.step:g} Hz, "
            f"sightings {1 / (UPDATES_PER_SIGHTING * motion.step):g} Hz",
            f"Q = diag({motion.speed_sd:g} m/s, {math.degrees(motion.steer_sd):g}°)²",
            f"R = diag({far:g} m, {math.degrees(aside):g}°)²",
            "ten frames at rest first" if self.still else "moving at once",
            f"{self.ekf.mode} form",
            self.draws.data.name if self.draws.data else f"seed {self.draws.seed}",
        )
        return "  ·  ".join(parts)

    def traces(self, number: int) -> dict[str, Trace]:
        """One drive through every estimator."""
        run = self.draws.run(number)
        return {PLAIN: reckoned(run)} | {name: mapped(run, ekf, self.still) for name, ekf in self._forms.items()}

    @property
    def _forms(self) -> dict[str, EkfSettings]:
        other = "invariant" if self.ekf.mode == "paper" else "paper"
        return {FIGURED: self.ekf, f"{FIGURED}_{other}": replace(self.ekf, mode=other)}


def drawn_drives(
    settings: Settings | None,
    seed: int,
    data: Path | None = None,
    noise: float | None = None,
    field: Field | None = None,
    still: bool = False,
    ids: Ids = "given",
) -> DrawnDrives:
    """Drives from a seed, or from a file. Without settings the filter has the paper's form. Raises BadInput."""
    ekf = EkfSettings(mode="paper", soft_gate=0.0) if settings is None else settings.ekf  # the paper trusts all alike
    ekf = replace(ekf, sighting_noise="corner")  # every sighting brings its own noise
    if data is not None:
        if noise is not None or field is not None:
            raise BadInput(f"The draws in {data.name} are made; leave out noise and field, or leave out the file.")
        if still and not len(frozen(data).still):
            raise BadInput(f"{data.name} has no frames at rest (still_obs).")
        return DrawnDrives(Draws(seed=seed, data=data, ids=ids), ekf, still)
    chosen, factor = settings or Settings(), 1.0 if noise is None else noise
    motion = replace(
        chosen.motion,
        model="paper",
        speed_sd=factor * chosen.motion.speed_sd,
        steer_sd=factor * chosen.motion.steer_sd,
    )
    spread = factor * chosen.ekf.range_sd, factor * chosen.ekf.bearing_sd
    draws = Draws(seed=seed, motion=motion, sighting_noise=spread, field=field or "laser", ids=ids)
    return DrawnDrives(draws, ekf, still)
