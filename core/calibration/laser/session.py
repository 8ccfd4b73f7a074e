"""The laser's wizard without a screen: the empty room first, then still poses of the board that both sensors see."""

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.quality import judge
from core.calibration.board.session import BoardSession, BoardVerdict, Explainer, Watcher
from core.calibration.camera.guidance import Advice, advice_of, clear
from core.calibration.laser import suspicion
from core.calibration.laser.board_line import average, find_lines, foreground
from core.calibration.laser.explanation import landings, laser_offset_words, weak_words
from core.calibration.laser.extrinsics import KNOWN_GAIN
from core.calibration.laser.plane_pairs import Guess, PlanePair, residuals_of, stack, whitening
from core.calibration.laser.planes import BoardPose, Plane, board_pose, plane_of
from core.calibration.laser.range_lines import fit_ranges, unit_rays
from core.calibration.laser.solve import LaserCalibration, LaserPose, calibrate_laser
from core.calibration.mount import NAMES, Extrinsics, Mount
from core.calibration.practice import BoardPlacement, held
from core.calibration.projection import Poses, linearise, vector_of
from core.errors import BadInput
from core.geometry import Transform
from core.message import Array
from core.optics import CameraModel
from core.sensors.laser import Scan

ADVISED_NEWNESS = 1.5  # times as new as a pose has to be are the poses that are advised: hands miss
RANGE_SD_M = 0.007  # of an averaged range, until it has been measured
EMPTY_ROOM_SCANS = 30  # scans of the empty room
POSE_SCANS = 20  # of every still pose
STILL_MOTION_PX = 0.7  # [pixel] mean motion of the corners between pictures, per 640 pixels of width
MAX_DRIFT_PX = 2.0  # [pixel] that the corners may wander in all while scans are gathered, per 640 pixels of width
MAX_BLIND_SCANS = 5  # scans that may come without a picture that shows the board still
NEW_POSE_TURN_RAD = np.deg2rad(8)  # by which its board is turned in a new pose
NEW_POSE_SHARE = 0.08  # of its distance, by which it is nearer or farther in a new pose
MIN_POSE_COUNT = 10
MIN_SOLVED_POSES = 4
MIN_SUSPECTED_POSES = 6  # poses that are enough to suspect the scans themselves
MAX_LANDING_PX = 3.0  # [pixel] within which a laser point at 1 m has to land (95 %)
CANDIDATE_POSES = 150
FIRST_SEED = 5
MIN_BEAMS = 15  # that have to meet the panel
CORNER_SD_PX = 0.2  # of a corner
HOLDING = BoardPlacement(nearest=0.35, farthest=1.2, least_tilt=0.0, most_tilt=np.deg2rad(55))


class LaserProgress(NamedTuple):
    """The progress of the wizard."""

    poses: int
    precision: dict[str, float]  # per direction: share by which the data have shrunk the mount's doubt, 0..1
    weak: tuple[str, ...]  # sentences
    laser_offset: str  # a sentence; empty before the first solution
    ready: bool
    words: str
    from_ruler: dict[str, str] = {}  # direction → how it was measured, where that speaks instead of the poses
    known_from: float = KNOWN_GAIN  # gain from which a direction counts as known


@dataclass
class TakenPose:
    """A pose in the session."""

    pose: LaserPose
    dropped: bool = False

    @property
    def name(self) -> str:
        """Its name."""
        return self.pose.name


def advise_pose(
    board: Board,
    model: CameraModel,
    rays: Array,
    range_sd: float,
    mount: Mount,
    so_far: Extrinsics | Poses,
    *,
    fresh: Callable[[Plane], bool] = lambda _: True,
    asked: int = 0,
) -> Advice | None:
    """Choose the pose that shrinks the largest uncertainty of the mount most, from what is known so far.

    `rays` (B, 3) are the laser's beams, `range_sd` [m] the noise of an averaged range, `so_far` a solution or, before
    there is one, the poses taken. Planes of the board that are not `fresh` would not be taken; `asked` counts the
    times that the operator asked for another pose. Where the mount's height was measured the board is only turned to
    the left and right: it stands upright. None where no fresh pose is in view of both sensors.
    """
    if isinstance(so_far, Poses):
        guess, known = Guess(mount.nominal.rotation, mount.nominal.translation), np.diag(1 / mount.sds**2)
        for gain in _information_of_each(so_far, board, model, rays, range_sd, guess):
            known = known + (0.0 if gain is None else gain)
    else:
        guess, known = so_far.guess, np.linalg.inv(so_far.covariance)
    holding = dataclasses.replace(HOLDING, upright="height" in mount.from_ruler)
    poses = held(np.random.default_rng(FIRST_SEED + asked), CANDIDATE_POSES, model, board, holding)
    poses = poses.take(clear(model, poses, board))
    best, best_left = None, np.inf
    for number, gain in enumerate(_information_of_each(poses, board, model, rays, range_sd, guess, fresh)):
        if gain is not None:
            left = float(np.sum(np.diag(np.linalg.inv(known + gain)) / mount.sds**2))
            best, best_left = (number, left) if left < best_left else (best, best_left)
    return None if best is None else advice_of(model, poses, best, board)


def beams_on_panel(rays: Array, laser_from_board: Transform, board: Board) -> tuple[Array, Array]:
    """Unit vectors (B, 3) → the numbers (K,) of the beams that meet the panel, and their ranges (K,) [m]."""
    normal = laser_from_board.rotation[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        ranges = (normal @ laser_from_board.translation) / (rays @ normal)
        places = laser_from_board.inverse().apply(rays * ranges[:, None]) - board.centre
        hit = (ranges > 0) & np.all(np.abs(places[:, :2]) <= board.half_size, axis=1)
    return np.flatnonzero(hit), ranges[hit]


def _information_of_each(
    poses: Poses,
    board: Board,
    model: CameraModel,
    rays: Array,
    range_sd: float,
    guess: Guess,
    fresh: Callable[[Plane], bool] = lambda _: True,
) -> Iterator[Array | None]:
    """Information (6, 6) that each pose gives about the mount; None where it is not fresh or the laser misses it."""
    mount = Transform(rotation=guess.rotation, translation=guess.translation)
    by_pose = linearise(vector_of(model), poses, board.points).by_pose
    covariances = CORNER_SD_PX**2 * np.linalg.inv(np.swapaxes(by_pose, 1, 2) @ by_pose)
    for number, covariance in enumerate(covariances):
        pose = poses.take(slice(number, number + 1))
        laser_from_board = mount @ Transform(rotation=pose.rotations[0], translation=pose.translations[0])
        beams, ranges = beams_on_panel(rays, laser_from_board, board)
        plane = plane_of(pose, covariance)
        if len(beams) < MIN_BEAMS or not fresh(plane):
            yield None
            continue
        seen = stack([PlanePair(plane=plane, ranges=fit_ranges(rays[beams], ranges, range_sd))])
        slope = residuals_of(seen, whitening(seen, guess))(guess)[1][:, :6]
        yield slope.T @ slope


class LaserSession(BoardSession[TakenPose, LaserCalibration]):
    """One calibration of the laser against a calibrated camera. Owned by one thread."""

    part, min_solved = "pose", MIN_SOLVED_POSES

    def __init__(self, board: Board, model: CameraModel, mount: Mount | None = None) -> None:
        super().__init__(board)
        self.model, self.mount = model, mount or Mount()
        self.background: Array | None = None  # (B,) [m]
        self._scans: list[Array] = []
        self._rays = np.empty((0, 3))
        self._watcher, self._explainer = Watcher(board), Explainer(board)
        self._seen: BoardPose | None = None
        self._corners: list[Array] = []  # (N, 2) [pixel] each, in every picture since gathering began
        self._blind = 0  # scans since the last picture

    def sweep(self, scan: Scan) -> BoardVerdict | None:
        """One scan → a verdict where it completes something: first the background, then every still pose."""
        ranges = np.where(scan.valid, scan.ranges, np.nan)
        if len(self._rays) not in (0, len(ranges)):
            raise BadInput("The laser's scans have changed their number of beams; start the session again.")
        self._rays = unit_rays(scan.angles)
        if self.background is None:
            self._scans.append(ranges)
            return self._empty_room()
        if self._seen is None:
            return None
        self._blind += 1
        if self._blind > MAX_BLIND_SCANS:
            self._forget()
            return BoardVerdict(kind="nothing", words="No pictures arrive; is the camera running?")
        self._scans.append(ranges)
        if len(self._scans) < POSE_SCANS:
            words = f"Hold still: {len(self._scans)} of {POSE_SCANS} scans."
            return BoardVerdict(kind="gathering", words=words, corners=self._watcher.corners)
        return self._take()

    def look(self, grey: Array, stamp: float = 0.0) -> BoardVerdict:
        """One picture (H, W) uint8 of time `stamp` [s] → its verdict. The board is still while scans are gathered."""
        if self.background is None:
            words = f"Looking at the empty room: keep out of it. {len(self._scans)} of {EMPTY_ROOM_SCANS} scans."
            return BoardVerdict(kind="background", words=words)
        view = self._watcher.look(grey)
        self._blind = 0
        if view is None:
            self._forget()
            return BoardVerdict(kind="nothing", words=self._explainer.why(grey, stamp))
        start = self._corners[0] if self._corners else None
        wandered = self._watcher.apart(view.corners, start, grey.shape[1]) > MAX_DRIFT_PX
        if self._watcher.moved > STILL_MOTION_PX or (self._seen is not None and wandered):
            self._forget()
            return BoardVerdict(kind="moving", words="Hold the board still.", corners=view.corners)
        if self._seen is not None:
            self._corners.append(view.corners)
            words = f"Hold still: {len(self._scans)} of {POSE_SCANS} scans."
            return BoardVerdict(kind="gathering", words=words, corners=view.corners)
        refusals = judge(grey, view, self.board).refusals
        if refusals:
            return BoardVerdict(kind="refused", words=refusals[0], corners=view.corners)
        pose = board_pose(self.model, self.board, view.corners)
        same = self._same(pose.plane)
        if same:
            words = f"Same as {same}; tilt or move the board."
            return BoardVerdict(kind="same", words=words, corners=view.corners)
        self._seen, self._corners, self._scans = pose, [view.corners], []
        return BoardVerdict(kind="gathering", words="Hold still …", corners=view.corners)

    def forget_room(self) -> None:
        """Scan the empty room again: the laser was moved, or a person was in the room. Poses keep their own room."""
        self.background = None
        self._forget()

    @property
    def poses(self) -> tuple[LaserPose, ...]:
        """The poses that take part."""
        return tuple(each.pose for each in self.taken if not each.dropped)

    def solve(self, *, printed: bool = False) -> LaserCalibration:
        """Solve here and now, `printed` by eq. 13.

        Raises BadInput with too few poses, or with the cause where the scans fit no board.
        """
        poses, found, trouble = self.poses, None, None
        try:
            found = calibrate_laser(poses, self.board, mount=self.mount, printed=printed)
        except BadInput as wrong:
            trouble = wrong
        if len(poses) >= MIN_SUSPECTED_POSES:
            doubt = suspicion.doubt_of(found, poses, (), self.board, None, self.mount)
            trouble = doubt or trouble
            found = found and replace(found, doubt=str(doubt or ""))
        if found is None:
            raise trouble or BadInput("The poses give no mount.")
        return self.adopt(found, self.names)

    def advice(self) -> Advice | None:
        """The most useful next pose; None before the first scan, or where none is in view of both sensors."""
        if not len(self._rays):
            return None
        known = self.calibration
        found, sd = (None, RANGE_SD_M) if known is None else (known.extrinsics, known.range_sd)
        boards = [pose.board for pose in self.poses]
        taken = Poses(
            np.array([board.rotation for board in boards]).reshape(-1, 3, 3),
            np.array([board.translation for board in boards]).reshape(-1, 3),
        )
        return advise_pose(
            self.board,
            self.model,
            self._rays,
            sd,
            self.mount,
            taken if found is None else found,
            fresh=lambda plane: not self._same(plane, ADVISED_NEWNESS),
            asked=self._asked,
        )

    def progress(self) -> LaserProgress:
        """The progress so far, and what is missing. An unknown room matters only where more poses are needed."""
        poses, calibration = len(self.poses), self.calibration
        missing = MIN_POSE_COUNT - poses
        first = "" if self.background is not None else "First the empty room: step out of the laser's view."
        if calibration is None:
            more = f"{missing} more pose{'s' * (missing > 1)} of the board at least."
            words = (first or more) if missing > 0 else "Not solved yet."
            return LaserProgress(poses, {}, (), "", False, words, self.mount.from_ruler)
        found = calibration.extrinsics
        offsets, sentences = landings(found, self.model), weak_words(found)
        landing = laser_offset_words(offsets)
        near = max(offsets[1]["sideways_px"], offsets[1]["up_down_px"]) <= MAX_LANDING_PX
        if missing > 0:
            words = first or f"{missing} more pose{'s' * (missing > 1)} at least."
        elif self.stale:
            words = "Not solved yet."
        elif calibration.doubt:
            words = calibration.doubt
        elif sentences:
            words = first or sentences[0]
        else:
            words = f"Done: {landing}" if near else first or f"Not yet exact: {landing}"
        ready = missing <= 0 and not self.stale and not sentences and near and not calibration.doubt
        precision = {name: float(gain) for name, gain in zip(NAMES, found.gain, strict=True)}
        return LaserProgress(poses, precision, sentences, landing, ready, words, found.from_ruler)

    def _empty_room(self) -> BoardVerdict:
        count, wanted = len(self._scans), EMPTY_ROOM_SCANS
        if count < wanted:
            words = f"Looking at the empty room: keep out of it. {count} of {wanted} scans."
            return BoardVerdict(kind="background", words=words)
        self.background, self._scans = average(np.array(self._scans), self._rays).ranges, []
        return BoardVerdict(kind="background", words="The empty room is known. Now show the board.")

    def _take(self) -> BoardVerdict:
        """Enough scans of a still board: find it among the beams that end before the empty room.

        Scans and pictures are both averaged over the same time, so that a hand that sways a little does no harm.
        """
        scan = average(np.array(self._scans), self._rays)
        pose = board_pose(self.model, self.board, np.mean(self._corners, axis=0))
        corners = self._watcher.corners
        self._forget()
        lines = find_lines(scan, foreground(scan, self.background), self.board)
        if not lines:
            words = "The laser does not meet the board: hold it at the laser's height, nearer, away from walls."
            return BoardVerdict(kind="refused", words=words, corners=corners)
        name = f"pose {len(self.taken) + 1}"
        self.taken.append(TakenPose(LaserPose(name=name, board=pose, scan=scan, background=self.background)))
        words = f"Counted as {name}: {len(lines[0])} beams on the board."
        return BoardVerdict(kind="counted", words=words, name=name, corners=corners, beams=lines[0])

    def _same(self, plane: Plane, newness: float = 1.0) -> str:
        """The name of the pose that this plane repeats, less than `newness` times as new as it has to be, or ''."""
        for each in self.taken:
            known = each.pose.board.plane
            angle = float(np.arccos(np.clip(known.normal @ plane.normal, -1, 1)))
            nearer = abs(known.distance - plane.distance) / known.distance
            if not each.dropped and angle < newness * NEW_POSE_TURN_RAD and nearer < newness * NEW_POSE_SHARE:
                return each.pose.name
        return ""

    def _forget(self) -> None:
        self._seen, self._scans, self._corners = None, [], []
