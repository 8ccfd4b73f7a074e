"""Agreement of wheels and scans: the moves that both claim are compared, and what explains a difference is named.

The scans' moves do not depend on the wheels being right, nor on the unit of the ranges. While all is well, scans far
apart are compared: they tell more, and cost less. While the two senses contradict each other every scan is looked at.
"""

import itertools
import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from core.geometry import Pose, wrap, wrap_all
from core.message import Array, message
from core.sensors import Fault, Laser, Scan, Wheels
from core.sensors.checks import fault
from core.slam.scan_matching.point_to_line import MIN_POINTS, WallPoints
from core.slam.scan_matching.scan_pairs import PairMatcher, ScanMove
from core.slam.scan_matching.wall_shapes import median_change

MIN_PAIR_S, LONG_PAIR_S, MAX_PAIR_S = 0.09, 0.45, 6.0  # between two scans: at least, enough at rest, at most
PAIR_M, PAIR_RAD = 0.04, math.radians(4)  # of a move that is long enough to compare
CALM_FACTORS = (6.0, 2.5, 2.0)  # times that way, turn and time, while all is well …
CALM_PAIRS = 3  # … which so many that agree show
REST_PAIRS = 4  # of that length that go by unseen after one, once nothing is undecided, …
STOOD_SHARE, CHANGED_SHARE = 0.015, 0.03  # … unless ranges change by less while wheels roll, by more while they stand
ROLLED_M, ROLLED_RAD = 0.12, math.radians(6)  # of wheels by which ranges must have changed
GUESSED_TURNS_RAD = (-0.15, 0.15)  # from which the search begins where nothing else fits …
# … and ways in all directions, where so much time has passed
GUESSED_WAYS_M, FAR_PAIR_S = ((0.3, 0.6, 0.9, 1.3, 1.7, 2.1), 1.0)
MIN_TRIED, MIN_FIT_SHARE = 16, 0.2  # moves, of which so many fit: else the ranges are no distances
TRACK_S, MAX_CARRIED_S = 8.0, 0.5  # of odometry that is kept, and carried on to the middle of a scan

STILL_M, STILL_RAD = 0.008, math.radians(0.5)  # below which a move is none
MOVED_M, MOVED_RAD = 0.025, math.radians(1.5)  # from which it is one
UNLIKE_M, UNLIKE_RAD, UNLIKE_SHARE = 0.03, math.radians(1.5), 0.4  # of a move, by which both may differ …
UNLIKE_RAD_M = 0.08  # … and per metre of it, by which wheels lead aside
MAX_SQUARED = 16.0  # distance between both, by what the walls show
ALONE_PAIRS, ALONE_M, ALONE_RAD = 3, 0.12, math.radians(8)  # of moves by one sense alone: wheels are not believed
TREMBLING_SHARE = 0.5  # of all those moves, which must be left of them: a pose that trembles leads nowhere
SAID_AFTER_S = 1.5  # of them that is said
BACK_PAIRS = 3  # that agree on the move: the wheels are believed again

KEPT_MOVES, MIN_MOVES, MAX_DIFFER_SHARE = 40, 30, 0.45  # that are looked at, and that contradict each other
KEPT_PAIRS, PAIRS_PER_LOOK = 80, 8  # that are judged together, and after how many new ones
MAX_SD_M, MAX_SD_RAD = 0.03, math.radians(1.0)  # of a move by scans that is judged
MIN_TURNS, MIN_WAYS = 12, 8  # pairs that show a turn, a way
TURN_RAD, WAY_M = math.radians(1.2), 0.02  # of one …
MIN_WAY_SHARE = 0.005  # … and of it by the wheels: less, and they stand
STRAIGHT_RAD = math.radians(15)  # of turn of a pair whose way is compared, at most
AGAINST_SHARE = 0.9  # of the turns that are the wrong way round
MISSED_SHARE, MAX_MISSED = 0.1, 0.3  # of a turn that the wheels show at least; of the turns that may show less
MAX_WAY_OFF, MAX_TURN_OFF = 0.05, 0.25  # of the logarithm of the wheels' share in a way, a turn
MAX_MOUNT_RAD, MOUNT_LENGTH = math.radians(8), 0.8  # off ahead; length of the mean direction
SURE_SDS, OUTLIER_SDS, KEPT_DOUBT = 4.0, 2.5, 0.7  # … of both for what was said before
SCAN_SD_M, SCAN_SD_RAD = 0.01, math.radians(0.3)  # of one move by scans, at least
MAX_LATE_S, LATE_STEP_S, MIN_LATE_S = 2.5, 0.05, 0.05  # of the search for a lateness; what is said
MUCH_LATE_S = 0.15  # from which moves at one time by scans and by wheels tell nothing else
MAX_RIPE_S = 1.2  # of a turn by which it is judged
TURN_SD_RAD, TURN_SD_SHARE = math.radians(0.15), 0.05  # of a turn by scans
MAX_TURN_SQUARED = 25.0  # difference of one turn that counts
LATE_SHARE, MAX_LATE_SQUARED, MIN_LATE_GAIN = 0.5, 3.0, 30.0  # left of differences and turns; per pair; explained
MAX_LATE_SCALE = 0.4  # by which late wheels turn more or less than the scans, at most: without a turn they fit as -1


Turn = tuple[float, float, Array]  # how long [s], by scans [rad], by wheels at each of LATES_S (L,) [rad]


@dataclass(frozen=True)
class PairStart:
    """The earlier scan of a pair to come."""

    stamp: float  # [s]
    scan: Scan
    odometry: Pose
    walls: WallPoints | None = None


@dataclass(frozen=True)
class MovePair:
    """The robot's move from one time to another, by scans and by wheels."""

    start: float  # [s]
    end: float  # [s]
    scans: ScanMove
    wheels: Pose

    @property
    def differs(self) -> bool:
        """Return whether both contradict each other in what the walls show."""
        seen, rolled = self.scans.pose, self.wheels
        off = rolled.inverse() @ seen
        far = math.hypot(off.x, off.y) > UNLIKE_M + UNLIKE_SHARE * max(_way(seen), _way(rolled))
        turn = UNLIKE_SHARE * max(abs(seen.heading), abs(rolled.heading)) + UNLIKE_RAD_M * _way(seen)
        return (far or abs(off.heading) > UNLIKE_RAD + turn) and self._is_sure

    @property
    def _is_sure(self) -> bool:
        """Return whether what the walls show excludes the wheels' move."""
        seen, rolled = self.scans.pose, self.wheels
        error = seen.vector - rolled.vector
        error[2] = wrap(float(error[2]))
        return float(error @ self.scans.information @ error) > MAX_SQUARED

    @property
    def moved_alone(self) -> str:
        """Code of the fault where only one of both moves; "": both do, or none."""
        seen, rolled = self.scans.pose, self.wheels
        if not self._is_sure:
            return ""
        if _is_still(rolled) and _has_moved(seen):
            return "agreement.wheels_stand"
        return "agreement.wheels_spin" if _is_still(seen) and _has_moved(rolled) else ""


def _way(move: Pose) -> float:
    return math.hypot(move.x, move.y)


def _is_still(move: Pose) -> bool:
    return _way(move) < STILL_M and abs(move.heading) < STILL_RAD


def _has_moved(move: Pose) -> bool:
    return _way(move) > MOVED_M or abs(move.heading) > MOVED_RAD


@message
class MoveAgreement:
    """Moves of a robot by its wheels over those by its scans, as far as it has moved."""

    laser: str  # name
    turns: int = 0  # moves that show a turn …
    ways: int = 0  # … and a way
    turn_scale: float | None = None  # the wheels' turn over the scans'; less than 0: mirrored; None: too few show it
    turn_sd: float | None = None  # … and its sd
    way_scale: float | None = None
    way_sd: float | None = None
    lateness: float = 0.0  # [s] to add to the stamps of the scans; 0: none is known


class OdometryPast:
    """The odometry of the last seconds, as it was read."""

    def __init__(self) -> None:
        self._rows: deque[tuple[float, float, float, float]] = deque()

    def add(self, stamp: float, wheels: Wheels) -> None:
        """Add the wheels of a frame at `stamp` [s]; no reading is added twice."""
        stamp, read = stamp - wheels.age, wheels.as_read
        heading = read.heading
        if self._rows:
            if stamp <= self._rows[-1][0] + 1e-6:
                return
            heading = self._rows[-1][3] + wrap(heading - self._rows[-1][3])
        self._rows.append((stamp, read.x, read.y, heading))
        while self._rows[0][0] < stamp - TRACK_S:
            self._rows.popleft()

    def columns(self, until: float) -> Array:
        """Stamps [s], x, y [m], headings [rad] without jumps, (K, 4), carried on `until` [s] a scan is over."""
        rows = np.array(self._rows).reshape(-1, 4)
        if len(rows) < 2 or not 0 < (ahead := until - rows[-1, 0]) < MAX_CARRIED_S:
            return rows
        return np.vstack([rows, rows[-1] + (rows[-1] - rows[-2]) * (ahead / (rows[-1, 0] - rows[-2, 0]))])


class LoneMoves:
    """Watches for moves of one sense alone: wheels that stand, or roll, while the scans do not."""

    def __init__(self) -> None:
        self._run: list[MovePair] = []
        self._kind, self._back = "", 0
        self.distrusts = False  # whether the wheels are not believed now
        self.missed: Pose | None = None  # with the pair that began it: from where the wheels led to where scans do
        self.newest = ("", 0.0, 0.0)  # code, since when [s], for how long [s]: what is to be said

    @property
    def began(self) -> float:
        """When the present run of moves of one sense began [s]."""
        return self._run[0].start if self._run else math.inf

    def end_run(self) -> None:
        """Begin again: the pairs are not one after the other any more."""
        self._run, self._kind = [], ""

    def take(self, pair: MovePair) -> None:
        """Take the next pair."""
        self.missed = None
        kind = pair.moved_alone
        if not kind and not _has_moved(pair.wheels):
            return
        if kind != self._kind:
            self.end_run()
        self._kind = kind
        if not kind:
            self._back = 0 if pair.differs else self._back + 1
            self.distrusts = self.distrusts and self._back < BACK_PAIRS
            return
        self._back = 0
        self._run.append(pair)
        self._judge()

    def _judge(self) -> None:
        rolled, seen, way, turn = Pose(), Pose(), 0.0, 0.0
        for pair in self._run:
            rolled, seen = rolled @ pair.wheels, seen @ pair.scans.pose
            off = pair.wheels.inverse() @ pair.scans.pose
            way, turn = way + TREMBLING_SHARE * _way(off), turn + TREMBLING_SHARE * abs(off.heading)
        off = rolled.inverse() @ seen
        stays = _way(off) < max(ALONE_M, way) and abs(off.heading) < max(ALONE_RAD, turn)
        if len(self._run) < ALONE_PAIRS or stays:
            return
        if not self.distrusts:
            self.distrusts, self.missed = True, off
        lasted = self._run[-1].end - self._run[0].start
        if lasted >= SAID_AFTER_S:
            self.newest = self._kind, self._run[0].start, lasted


class SenseAgreement:
    """Compares the wheels' moves with those by one laser's scans; `update` with every frame."""

    def __init__(self, laser: Laser) -> None:
        self._laser = laser
        self._past, self._matcher, self._lone = OdometryPast(), PairMatcher(laser), LoneMoves()
        self._base: PairStart | None = None
        self._last: MovePair | None = None  # None: the newest scans did not fit
        self._calm, self._looked = 0, 0
        self._decided, self._rests = False, False  # whether all that is compared agrees; between two pairs
        self._tried, self._fitted = 0, 0  # moves by the wheels with walls to see, and those that scans show
        self._began: float | None = None  # [s] of the first frame
        self._pairs: deque[MovePair] = deque(maxlen=KEPT_PAIRS)
        self._ripening: deque[MovePair] = deque(maxlen=KEPT_PAIRS)
        # of the newest moves, whether both contradict each other
        self._differ: deque[bool] = deque(maxlen=KEPT_MOVES)
        self._turns: deque[Turn] = deque(maxlen=KEPT_PAIRS)
        self._found: dict[str, Fault] = {}
        self._late_before, self._scales_before = 0.0, (1.0, 1.0)  # [s] and of turns and ways, when judged last
        self.lateness = 0.0  # [s] to add to the stamps of the scans; 0: none is known
        self.compared = MoveAgreement(laser=laser.name)  # when it was judged last

    @property
    def distrusts(self) -> bool:
        """True while the wheels are not believed."""
        return self._lone.distrusts

    @property
    def decided(self) -> bool:
        """True where wheels and scans agree in all that is compared."""
        return self._decided

    @property
    def faults(self) -> tuple[Fault, ...]:
        """All that was found, the newest of each kind."""
        return tuple(self._found.values())

    @property
    def missed(self) -> Pose | None:
        """From where the wheels led to where the scans do, in the frame from which on the wheels are not believed."""
        return self._lone.missed

    @property
    def velocity(self) -> Pose | None:
        """The newest move by scans, per second; None: not known."""
        last = self._last
        if last is None:
            return None
        lasted, move = last.end - last.start, last.scans.pose
        return Pose(move.x / lasted, move.y / lasted, move.heading / lasted)

    def update(self, stamp: float, wheels: Wheels, scan: Scan | None, fresh: bool = True) -> None:
        """Take the wheels at `stamp` [s], not `fresh` where none came, and a scan of this laser."""
        self._began = stamp if self._began is None else self._began
        self._lone.missed = None
        self._past.add(stamp, wheels)
        if scan is None:
            return
        middle = scan.stamp + self._laser.time_offset + 0.5 * scan.time_step * (len(scan.ranges) - 1)
        base = self._base
        if base is None or not 0 < middle - base.stamp <= MAX_PAIR_S:
            self._base = PairStart(middle, scan, wheels.odometry)
            self._lone.end_run()
            return
        elapsed = middle - base.stamp
        way, turn, lasts = CALM_FACTORS if self._calm >= CALM_PAIRS else (1.0, 1.0, 1.0)
        rolled = base.odometry.inverse() @ wheels.odometry
        if self._rests:
            rest = REST_PAIRS * way
            self._rests = not self._is_odd(rolled, scan, base.scan)
            if self._has_come(rolled, elapsed, rest * PAIR_M, rest * PAIR_RAD) or elapsed > REST_PAIRS * LONG_PAIR_S:
                self._base, self._rests = PairStart(middle, scan, wheels.odometry), False
                return
        if self._rests:
            return
        moved = self._last is None or self._has_come(rolled, elapsed, way * PAIR_M, turn * PAIR_RAD)
        if elapsed >= MIN_PAIR_S and (moved or elapsed >= lasts * LONG_PAIR_S):
            self._compare(base, PairStart(middle, scan, wheels.odometry, self._matcher.walls_of(scan)), fresh)

    def _is_odd(self, rolled: Pose, scan: Scan, before: Scan) -> bool:
        change = median_change(scan.ranges, before.ranges)
        if _is_still(rolled):
            return change > CHANGED_SHARE
        return change < STOOD_SHARE and (_way(rolled) > ROLLED_M or abs(rolled.heading) > ROLLED_RAD)

    def finish(self) -> None:
        """Judge what is left: nothing more comes."""
        self._say_misfit()
        self._judge()
        self._say_difference()

    def _say_difference(self) -> None:
        share = sum(self._differ) / max(len(self._differ), MIN_MOVES)
        if share > MAX_DIFFER_SHARE and not self._found:
            self._say("agreement.differ", share=f"{100 * share:.0f}")
        elif len(self._found) > 1:
            self._found.pop("agreement.differ", None)

    def _has_come(self, rolled: Pose, elapsed: float, far: float, turned: float) -> bool:
        """Return whether the robot has come `far` [m] or `turned` [rad] in `elapsed` [s] by either sense."""
        rate = self.velocity or Pose()
        way, turn = max(_way(rolled), elapsed * _way(rate)), max(abs(rolled.heading), elapsed * abs(rate.heading))
        return way >= far or turn >= turned

    def _compare(self, base: PairStart, now: PairStart, fresh: bool) -> None:
        self._base = now
        track = self._past.columns(now.stamp)
        if now.walls is None or len(track) < 2 or track[0, 0] > base.stamp + 1e-6:
            return
        rolled = _moved(track, base.stamp, now.stamp)
        walls = base.walls or self._matcher.walls_of(base.scan)
        found = self._matcher.match(walls, now.walls, self._guesses(rolled, now.stamp - base.stamp))
        if _has_moved(rolled) and min(len(walls.points), len(now.walls.points)) >= MIN_POINTS:
            self._tried += 1
            self._fitted += found is not None
        if found is None:
            self._say_misfit()
            self._last, self._calm = None, 0
            self._lone.end_run()
            return
        self._last = pair = MovePair(base.stamp, now.stamp, found, rolled)
        differs = pair.differs
        self._calm = 0 if differs or self.distrusts else self._calm + 1
        self._rests = self._decided and self._calm >= CALM_PAIRS
        if _has_moved(pair.wheels) or _has_moved(found.pose):
            self._differ.append(differs)
        self._lone.take(pair)
        code, since, lasted = self._lone.newest
        if code and fresh and abs(self.lateness) < MUCH_LATE_S:
            self._say(code, at=f"{since - (self._began or 0.0):.1f}", lasted=f"{lasted:.1f}")
        self._lone.newest = ("", 0.0, 0.0)
        if self._lone.missed is not None:
            self._forget_since(self._lone.began)
        self._keep(pair, track)

    def _say_misfit(self) -> None:
        if self._tried >= MIN_TRIED and self._fitted < MIN_FIT_SHARE * self._tried:
            self._say("agreement.no_fit", used=False, fits=f"{self._fitted}", tried=f"{self._tried}")
        else:
            self._found.pop("agreement.no_fit", None)

    def _forget_since(self, start: float) -> None:
        """Leave out the pairs from `start` [s] on: in them the wheels were wrong."""
        for kept in (self._pairs, self._ripening):
            while kept and kept[-1].end > start:
                kept.pop()

    def _guesses(self, rolled: Pose, elapsed: float) -> Iterator[Pose]:
        """Moves from which the search begins: as before, by the wheels, none, and by the wheels turned round."""
        rate = self.velocity
        if rate is not None:
            yield Pose(elapsed * rate.x, elapsed * rate.y, wrap(elapsed * rate.heading))
        yield rolled
        yield Pose()
        yield Pose(rolled.x, -rolled.y, -rolled.heading)
        yield Pose(-rolled.x, -rolled.y, rolled.heading)
        for turn in GUESSED_TURNS_RAD:
            yield Pose(0.0, 0.0, turn)
        if elapsed < FAR_PAIR_S or _is_still(rolled):
            return
        for way, direction in itertools.product(GUESSED_WAYS_M, np.arange(0.0, math.tau, math.pi / 4).tolist()):
            yield Pose(way * math.cos(direction), way * math.sin(direction), rolled.heading)

    def _keep(self, pair: MovePair, track: Array) -> None:
        """Keep a pair whose move is sure, its turn once the odometry around it is known; judge now and then."""
        place_sd, heading_sd = pair.scans.sds
        if heading_sd > MAX_SD_RAD or self.distrusts:
            return
        if place_sd * self._matcher.scale < MAX_SD_M:
            self._pairs.append(pair)
        if pair.end - pair.start < MAX_RIPE_S:
            self._ripening.append(pair)
        while self._ripening and self._ripening[0].end + MAX_LATE_S <= track[-1, 0]:
            ripe = self._ripening.popleft()
            move = ripe.scans
            if ripe.start - MAX_LATE_S >= track[0, 0]:
                ends = np.interp(np.add.outer((ripe.start, ripe.end), LATES_S), track[:, 0], track[:, 3])
                self._turns.append((ripe.end - ripe.start, move.pose.heading, ends[1] - ends[0]))
        self._looked += 1
        if self._looked % PAIRS_PER_LOOK == 0:
            self._judge()
            if len(self._differ) == KEPT_MOVES:
                self._say_difference()

    def _judge(self) -> None:
        """Name what explains the difference between wheels and scans."""
        (late, timely), before = find_lateness(self._turns), self._late_before
        self._late_before, self._decided = late, False
        if late and before and abs(late - before) < 2 * LATE_STEP_S:
            self.lateness = late
            for code in () if abs(late) < MUCH_LATE_S else ("agreement.wheels_stand", "agreement.wheels_spin"):
                self._found.pop(code, None)
            said = late_scans(self._laser.name or "the laser", late)
            self._found[said.code] = said
        moves = [pair.scans for pair in self._pairs]
        seen = np.array([move.pose.vector for move in moves]).reshape(-1, 3)
        rolled = np.array([pair.wheels.vector for pair in self._pairs]).reshape(-1, 3)
        self.compared = compare(self._laser.name, seen, rolled, self.lateness, SCAN_SD_M / self._matcher.scale)
        if abs(self.lateness) >= MUCH_LATE_S or len(self._pairs) < MIN_TURNS:
            return
        turned = find_turn_scale(seen, rolled, self._doubt("agreement.turn_scale"))
        doubt = self._doubt("agreement.way_scale")
        scale, aside = find_way_scale(seen, rolled, SCAN_SD_M / self._matcher.scale, doubt)
        before, self._scales_before = self._scales_before, (turned, scale)
        if turned < 0 and before[0] < 0:
            self._say("agreement.mirrored")
        for code, size, one in (
            ("agreement.turn_scale", turned, before[0]),
            ("agreement.way_scale", 1.0 if aside or turned < 0 else scale, before[1]),
        ):
            if size > 0 and 1.0 not in (size, one):
                self._say(code, times=f"{size:.3g}")
            else:
                self._found.pop(code, None)
        if aside:
            heading = wrap(self._laser.mounting.heading - aside)
            self._say("agreement.mount", off=f"{math.degrees(aside):.0f}", heading=f"{heading:.2f}")
        shown = self.compared
        agree = timely and (turned, scale, aside) == (1.0, 1.0, 0.0) and not self._found
        self._decided = agree and None not in (shown.turn_scale, shown.way_scale)

    def _doubt(self, code: str) -> float:
        """Return the share of the usual proof that is enough: what was said once is not taken back at once."""
        return KEPT_DOUBT if code in self._found else 1.0

    def _say(self, code: str, *, used: bool = True, **values: str) -> None:
        name = self._laser.name or "the laser"
        self._found[code] = fault(code, name, used=used, **values)


def late_scans(laser: str, offset: float) -> Fault:
    """Make the fault of scans to whose stamps `offset` [s] is to be added."""
    return fault("agreement.early" if offset > 0 else "agreement.late", laser, used=True, late=f"{abs(offset):.2f}")


LATES_S = np.arange(-MAX_LATE_S, MAX_LATE_S + 1e-9, LATE_STEP_S)


def find_lateness(turns: deque[Turn]) -> tuple[float, bool]:
    """Turns by scans, and by the wheels at each of LATES_S → what to add to the scans' stamps [s], 0: nothing is
    known, and whether a large one is excluded."""
    if len(turns) < MIN_TURNS:
        return 0.0, False
    lasted, seen, rolled = (np.array(column) for column in zip(*turns, strict=True))
    sds = TURN_SD_RAD + TURN_SD_SHARE * np.abs(seen)
    off, others = (rolled - seen[:, None]) / sds[:, None], np.column_stack([seen, lasted]) / sds[:, None]
    fitted = np.linalg.lstsq(others, off, rcond=None)[0]  # (2, L): scale of turns, drift
    costs = np.minimum((off - others @ fitted) ** 2, MAX_TURN_SQUARED).sum(axis=0)
    none, turned = float(costs[len(costs) // 2]), float(np.minimum((seen / sds) ** 2, MAX_TURN_SQUARED).sum())
    costs = np.where(np.abs(fitted[0]) < MAX_LATE_SCALE, costs, np.maximum(costs, none))
    best = int(costs.argmin())
    late, left = float(LATES_S[best]), float(costs[best])
    most = min(LATE_SHARE * none, LATE_SHARE * turned, MAX_LATE_SQUARED * len(turns), none - MIN_LATE_GAIN)
    if left >= most or abs(late) < MIN_LATE_S - 1e-9:
        return 0.0, bool(costs[np.abs(LATES_S) >= MUCH_LATE_S].min() > none + MIN_LATE_GAIN)
    before, _, after = costs[best - 1 : best + 2] if 0 < best < len(costs) - 1 else (left, left, left)
    return late + 0.5 * LATE_STEP_S * float((before - after) / max(before + after - 2 * left, 1e-9)), False


def compare(laser: str, seen: Array, rolled: Array, lateness: float, least_sd: float = SCAN_SD_M) -> MoveAgreement:
    """Moves (N, 3) by scans, with their sd [m], and by wheels → what they say of each other."""
    turns, ways = _turning(seen, rolled), _straight(seen, rolled)
    turn_sd, way_sd = SCAN_SD_RAD / _rms(seen[turns, 2]), least_sd / _rms(seen[ways, :2])
    return MoveAgreement(
        laser=laser,
        turns=int(turns.sum()),
        ways=int(ways.sum()),
        turn_scale=_ratio(rolled[turns, 2:], seen[turns, 2:]) if turns.sum() >= MIN_TURNS else None,
        turn_sd=turn_sd if turns.sum() >= MIN_TURNS else None,
        way_scale=_ratio(rolled[ways, :2], seen[ways, :2]) if ways.sum() >= MIN_WAYS else None,
        way_sd=way_sd if ways.sum() >= MIN_WAYS else None,
        lateness=lateness,
    )


def _ratio(rolled: Array, seen: Array) -> float:
    """Size of moves (N, D) by wheels over those by scans, by least squares; less than 0: against each other."""
    along = (rolled * seen).sum(axis=1)
    sense = math.copysign(1.0, float(along.sum()))
    return sense * float((rolled**2).sum() / max(np.abs(along).sum(), 1e-9))


def _rms(moves: Array) -> float:
    return max(float(np.sqrt((moves**2).sum())), 1e-9)


def _turning(seen: Array, rolled: Array) -> Array:
    """Return which moves show a turn (N,)."""
    return (np.abs(seen[:, 2]) > TURN_RAD) & (np.abs(rolled[:, 2]) > 0.3 * TURN_RAD)


def _straight(seen: Array, rolled: Array) -> Array:
    """Return which moves show a way (N,)."""
    long = (np.hypot(*seen[:, :2].T) > WAY_M) & (np.hypot(*rolled[:, :2].T) > MIN_WAY_SHARE * WAY_M)
    return long & (np.abs(seen[:, 2]) < STRAIGHT_RAD)


def find_turn_scale(seen: Array, rolled: Array, doubt: float = 1.0) -> float:
    """Moves (N, 3) by scans and by wheels → the wheels' turn over the scans'; 1: nothing is wrong, < 0: mirrored."""
    turns = _turning(seen, rolled)
    if turns.sum() < MIN_TURNS:
        return 1.0
    share = rolled[turns, 2] / seen[turns, 2]
    if np.mean(share < 0) >= AGAINST_SHARE:
        return -1.0
    alike, sizes = share > 0, np.abs(seen[turns, 2])
    scale = _scale(share[alike], sizes[alike], doubt * MAX_TURN_OFF, doubt * SURE_SDS, SCAN_SD_RAD / _rms(sizes))
    return scale if scale != 1.0 else _share_of_turns(seen[:, 2], rolled[:, 2])


def find_way_scale(
    seen: Array, rolled: Array, least_sd: float = SCAN_SD_M, doubt: float = 1.0
) -> tuple[float, float]:
    """Moves (N, 3) by scans, with their sd [m], and by wheels → the wheels' way over the scans', and how far aside
    these lead [rad].

    (1, 0): nothing is wrong.
    """
    ahead = _straight(seen, rolled)
    if ahead.sum() < MIN_WAYS:
        return 1.0, 0.0
    ways, claimed = np.hypot(*seen[ahead, :2].T), np.hypot(*rolled[ahead, :2].T)
    scale = _scale(claimed / ways, ways, doubt * MAX_WAY_OFF, doubt * SURE_SDS, least_sd / _rms(ways))
    off = wrap_all(_direction(seen[ahead]) - _direction(rolled[ahead]))
    mean = np.exp(1j * off).mean()
    rest = wrap_all(off - np.angle(mean))
    aside = wrap(float(np.angle(mean) + np.median(rest)))
    sure = abs(mean) > MOUNT_LENGTH and abs(aside) > max(MAX_MOUNT_RAD, SURE_SDS * _median_sd(rest))
    return scale, aside if sure else 0.0


def _scale(shares: Array, sizes: Array, most: float, sds: float, least_sd: float) -> float:
    """The mean of shares (N,), weighed by the sizes of the moves, outliers left out; 1 where it is not surely off by
    more than `most` and `sds` of its logarithm.

    `least_sd` of it: few that happen to lie close together are no surer than the scans.
    """
    off, weights = np.log(shares), sizes**2
    apart = np.abs(off - np.median(off))
    weights = np.where(apart <= OUTLIER_SDS * 1.483 * np.median(apart), weights, 0.0) / weights.sum()
    mean = float((weights * off).sum() / weights.sum())
    sd = float(np.sqrt((weights**2 * (off - mean) ** 2).sum())) / float(weights.sum())
    return math.exp(mean) if abs(mean) > max(most, sds * max(sd, least_sd)) else 1.0


def _share_of_turns(seen: Array, rolled: Array) -> float:
    """Turns (N,) by scans and by wheels → their share, where wheels do not show many of them; 1: they do."""
    seen, rolled = seen[np.abs(seen) > TURN_RAD], rolled[np.abs(seen) > TURN_RAD]
    share = float((seen * rolled).sum() / max((seen**2).sum(), 1e-9))
    missed = np.abs(seen)[np.abs(rolled) < MISSED_SHARE * np.abs(seen)].sum()
    return share if missed > MAX_MISSED * np.abs(seen).sum() and 0 < share < math.exp(-MAX_TURN_OFF) else 1.0


def _direction(moves: Array) -> Array:
    """Moves (N, 3) → their directions (N,) [rad] in the frame halfway."""
    return np.arctan2(moves[:, 1], moves[:, 0]) - 0.5 * moves[:, 2]


def _median_sd(values: Array) -> float:
    """Return the sd of the median of values (N,)."""
    return float(1.858 * np.median(np.abs(values - np.median(values))) / math.sqrt(len(values)))


def _moved(track: Array, start: float, end: float) -> Pose:
    """The wheels' move between two times [s], by a track (K, 4)."""
    (x0, x1), (y0, y1), (h0, h1) = (np.interp((start, end), track[:, 0], track[:, k]).tolist() for k in (1, 2, 3))
    return Pose(x0, y0, h0).inverse() @ Pose(x1, y1, wrap(h1))
