"""Following one person over time: laser legs and pictures against a prediction that outlives short occlusions."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from core.geometry import Pose, Ray
from core.message import Array
from core.perception.people.appearance import (
    MIN_SIGHTS,
    NEAR_LEGS_M,
    RATIO_MARGIN,
    SURE_RATIO,
    Appearance,
    Identity,
    PersonProfile,
    alike,
    colours_seen,
)
from core.perception.people.brightness import levelled
from core.perception.people.camera_geometry import (
    LEGS_BESIDE_M,
    around,
    eye,
    from_eye,
    in_world,
    legs_of,
    off_axis,
    on_legs,
    ray_of,
    stands_at,
)
from core.perception.people.detector import Rectangle, find_people
from core.perception.people.fusion import Fused, Sense, along, fuse
from core.perception.people.leg_tracks import MAX_LEGS_AGE_S, POSITION_SD, LegTrack, OtherLegs
from core.perception.people.legs import LegCluster, find_standers
from core.perception.people.looking import PersonLook
from core.perception.people.parts import PeopleSettings
from core.perception.people.person_pictures import PersonPictures, legs_alone, only_legs_show
from core.perception.people.search import MAX_PLANES, Glance, Search
from core.perception.people.tracked_person import TrackedPerson, TrackSettings
from core.perception.people.vertical_plane import VerticalPlanes
from core.perception.people.voice_bearing import VoiceBearing
from core.sensors import Camera, Image

DISTANCE_SD = 0.15  # share of a distance that only the picture gives
IN_VIEW, ASIDE_RAD = 1.3, 0.4  # [m], [rad] nearer or farther aside, too little of a person is in the picture
MISTAKEN_SD_M = 0.3  # sd that is added where a picture shows that the legs at the person's place are another's
MAX_HIDDEN_S = 0.5  # without a measurement, after which the person may have stopped, or be elsewhere
LOOKS_MEMORY_S = 1.0  # for which it counts how much a picture showed the person at their place
NEWEST_SHARE = 0.3  # share of the newest picture in that
WALKING_SPEED_M_S = 0.15  # from which someone else is walking now
STEADY_TIME_S = 0.5  # for which a person's acceleration lasts


class PersonTrack:
    """One person, from the first rectangle on."""

    def __init__(
        self,
        settings: PeopleSettings,
        tracking: TrackSettings,
        who: PersonProfile | None = None,
        look: PersonLook | None = None,
    ) -> None:
        """`who`: only this person counts; `look`: what finds people in pictures, None: the embedded detector."""
        self._asked = None if look is None else PersonPictures(look)
        self._settings, self._tracking, self._who = settings, tracking, who
        self._known = replace(settings, threshold=tracking.known, threshold_of_feet=tracking.known)
        self._state = np.zeros(4)
        self._covariance = np.eye(4)
        self._stamp = 0.0  # [s] of the state
        self._identity = Identity(tracking.alike)
        self._pictures = 0
        self.strangers = False  # a person was seen where the voice came from, but not the one searched for
        self.measured = -math.inf  # [s]
        self.pictured = -math.inf  # [s] when a picture showed the person
        self.looked = -math.inf  # [s] when a picture came at all
        self.judged = 0  # pictures that were searched to their end
        self.only_legs = False  # the person is so near that the camera sees no more of them: the laser decides
        self._excused = -math.inf  # [s] when no picture could have shown enough of the person
        self._seen: TrackedPerson | None = None
        self._scanned = -math.inf  # [s] of the newest scan
        self._glance: Glance | None = None
        self._others = OtherLegs()
        self._on_legs = math.inf  # [s] when the person last stood on legs that the laser saw; ∞: never yet
        # the newest picture of the person's place: its stamp [s], and how alike the person is who stands there
        self._likely = (-math.inf, 0.0)
        # the newest picture with others in it: its stamp [s], the eye, and their rectangles
        self._strangers = (-math.inf, Pose(), list[Rectangle]())
        self._questions = 0  # about the followed person

    @property
    def person(self) -> TrackedPerson | None:
        """The followed person; None before one was found."""
        return self._seen if self._pictures >= self._tracking.births else None

    def apart_from(self, place: Array) -> float:
        """Distance [m] of the person from a place (2,) [m], world."""
        return float(np.hypot(*(self._state[:2] - place)))

    def passed_by(self, place: Array, stamp: float, within: float) -> bool:
        """Return whether someone else walks within that distance [m] of a place (2,) [m], world."""
        others = self._others.near(place, stamp, walking=True)
        return any(one.speed > WALKING_SPEED_M_S and np.hypot(*(one.place - place)) < within for one in others)

    def lost(self, stamp: float) -> bool:
        """True when the person has been hidden for too long."""
        return self._seen is not None and stamp - self.measured > self._tracking.patience

    def begin(
        self, call: VoiceBearing, stamp: float, pose: Pose, points: Array, image: Image | None, camera: Camera
    ) -> None:
        """Search one frame further where the call came from. Found in a few pictures, they are followed."""
        if image is not None:
            self.looked = stamp
        if self._asked is not None:
            self._begin_with(self._asked, call, stamp, pose, points, image, camera)
            return
        if image is not None:
            self._glance = self._glance or self._looking(call, stamp, pose, points, image, camera)
        glance = self._glance
        found = None if glance is None else glance.search.go_on()
        if glance is None or found is None:
            return
        self._glance = None
        self.judged += 1
        self.strangers |= glance.search.strangers
        camera = glance.search.boards.camera
        for rectangle in found:
            ray = ray_of(rectangle, eye(glance.pose, camera), glance.pose)
            stander = legs_of(rectangle, glance.standers, camera, self._settings)
            if rectangle.shown < self._settings.enough and not on_legs(rectangle, stander, self._settings):
                continue
            self._first(call, glance.stamp, glance.pose, ray, rectangle, stander)
            self._identity.learn(_looks_of(glance.search.boards, rectangle), glance.stamp)
            return
        legs = legs_alone(glance.standers, camera, _towards(call, glance.pose))
        if legs is not None and self._who is None:
            self._first(call, glance.stamp, glance.pose, None, None, legs)

    def begin_by_legs(self, call: VoiceBearing, stamp: float, pose: Pose, points: Array, camera: Camera) -> None:
        """Search by the laser alone, where no picture was judged in time, for legs above which none shows a body."""
        legs = legs_alone(find_standers(points), camera, _towards(call, pose))
        if legs is not None and self._who is None:
            self._first(call, stamp, pose, None, None, legs)

    def _begin_with(
        self,
        asked: PersonPictures,
        call: VoiceBearing,
        stamp: float,
        pose: Pose,
        points: Array,
        image: Image | None,
        camera: Camera,
    ) -> None:
        """Ask who stands where the call came from; an answer may come with a later frame."""
        if image is not None:
            asked.ask_towards(image, camera, pose, find_standers(points), _towards(call, pose), stamp)
        answered = asked.answer()
        if answered is None:
            return
        self.judged += 1
        for rectangle in answered.found:
            if not self._is_who(rectangle):
                self.strangers = True
                continue
            ray = ray_of(rectangle, eye(answered.pose, answered.camera), answered.pose)
            stander = legs_of(rectangle, answered.standers, answered.camera, self._settings)
            self._first(call, answered.stamp, answered.pose, ray, rectangle, stander)
            self._identity.learn(rectangle.looks, answered.stamp)
            return
        if answered.legs is not None and self._who is None:
            self._first(call, answered.stamp, answered.pose, None, None, answered.legs)

    def _is_who(self, rectangle: Rectangle) -> bool:
        if self._who is None or rectangle.looks is None:
            return self._who is None
        return alike(self._who.looks, rectangle.looks) >= self._settings.alike

    def _looking(
        self, call: VoiceBearing, stamp: float, pose: Pose, points: Array, image: Image, camera: Camera
    ) -> Glance:
        bearing, sd = _towards(call, pose)
        wedge = sd * self._settings.wedge
        standers = find_standers(points)
        seen = [from_eye(one, camera) for one in standers]
        near = [far for far, angle in seen if abs(math.remainder(angle - bearing, math.tau)) < wedge + 0.3 / far]
        boards = VerticalPlanes(levelled(image.pixels), camera)
        least = min(self._settings.threshold_of_feet, self._settings.feet_with_legs)
        settings = replace(self._settings, threshold_of_feet=least)
        return Glance(Search(boards, (bearing, wedge), near, settings, self._who), stamp, pose, standers)

    def follow(
        self, stamp: float, pose: Pose, points: Array, scanned: float, image: Image | None, camera: Camera | None
    ) -> None:
        """One frame further: predict, and correct by what is new; `scanned` [s]: the stamp of the points' scan."""
        if self._seen is None:
            return
        self._predict(stamp)
        stander: LegCluster | None = None
        rectangle: Rectangle | None = None
        fresh_scan = scanned != self._scanned
        self._scanned = scanned
        standers = find_standers(points, every=True) if fresh_scan or image is not None else ()
        others: list[Rectangle] = []
        if image is not None:
            self.looked = stamp
        if camera is None:
            self._excused = stamp  # nothing looks there, so that no picture can show the person
        elif self._asked is not None:
            self._excuse(camera, pose)
            rectangle, others = self._follow_with(self._asked, stamp, pose, standers, image, camera)
        elif image is not None:
            rectangle, others = self._look(VerticalPlanes(levelled(image.pixels), camera), pose, standers)
        if camera is not None and (others or rectangle is not None):
            rectangle = self._identify(rectangle, others, eye(pose, camera))
        if fresh_scan or rectangle is not None:
            stander = self._legs(stamp, pose, standers, self._legs_of_strangers(standers, pose, camera))
        self._correct(stamp, pose, stander, rectangle, camera)
        if rectangle is not None:
            self._identity.learn(rectangle.looks, stamp)

    # steps of the above

    def _first(
        self,
        call: VoiceBearing,
        stamp: float,
        pose: Pose,
        ray: Ray | None,
        rectangle: Rectangle | None,
        stander: LegCluster | None,
    ) -> None:
        """Lock on, or believe a little more: by a rectangle and its ray, by legs, or by both."""
        if stander is not None:
            start = in_world(stander, pose)
        else:
            assert ray is not None and rectangle is not None
            start = along(ray, rectangle.distance, DISTANCE_SD * rectangle.distance)
        rays: tuple[tuple[Sense, Ray], ...] = (("sound", call.ray),)
        if ray is not None:
            rays = (("camera", ray), *rays)
        fused = fuse(start, rays, "laser" if stander else None)
        place = np.append(fused.position, (0.0, 0.0))
        if self._pictures and np.hypot(*(self._state - place)[:2]) > 0.4:
            self._pictures = 0  # another person than in the picture before
        self._state, self._stamp, self._pictures = place, stamp, self._pictures + 1
        self._covariance = np.zeros((4, 4))
        self._covariance[:2, :2] = fused.covariance
        self._covariance[2:, 2:] = self._tracking.walking**2 * np.eye(2)
        self._tell(stamp, fused, rectangle, start[0] if stander else None, ray, call.ray)

    def _follow_with(
        self,
        asked: PersonPictures,
        stamp: float,
        pose: Pose,
        standers: tuple[LegCluster, ...],
        image: Image | None,
        camera: Camera,
    ) -> tuple[Rectangle | None, list[Rectangle]]:
        """Ask for the person where they are expected → the person in the newest answer, and others."""
        here = eye(pose, camera)
        x, y = self._to_look_at(stamp)
        bearing, distance = here.bearing_to(x, y), here.distance_to(x, y)
        if image is not None and distance > 0.3:
            across = math.sqrt(float(np.linalg.eigvalsh(self._covariance[:2, :2])[-1]))
            sd = min(0.3, math.hypot(0.02, across / distance))
            self._questions += asked.ask_for(image, camera, pose, standers, (bearing, sd), distance, stamp)
        answered = asked.answer()
        if answered is None:
            return None, []
        own, others = self._own_among(
            [_seen_from(here, one, eye(answered.pose, answered.camera)) for one in answered.found], here
        )
        if own is not None:
            own = self._moved_on(own, stamp - answered.stamp, here)
        return own, others

    def _to_look_at(self, stamp: float) -> tuple[float, float]:
        """Place (x, y) [m], world, of the next question: the person's, in doubt also that of other legs."""
        candidates = self._candidates(stamp)
        turn, other = divmod(self._questions, 2)
        x, y = (candidates[turn % len(candidates)].place if other and candidates else self._state[:2]).tolist()
        return x, y

    def _candidates(self, stamp: float) -> list[LegTrack]:
        """Other legs that may be the person's: in doubt those of walkers, and any when the person is gone."""
        gone = stamp - self.measured > MAX_HIDDEN_S
        if not gone and not self._identity.is_doubtful(stamp):
            return []
        return self._others.near(self._state[:2], stamp, walking=not gone and self._likely[1] > SURE_RATIO)

    def _own_among(self, found: Sequence[Rectangle], here: Pose) -> tuple[Rectangle | None, list[Rectangle]]:
        """Rectangles with looks, as seen from `here` → the person's, and the others."""
        judged = self._identity.is_settled or self._identity.is_doubtful(self._stamp)
        fitting = [one for one in found if self._fits(one, here)]
        fitting = [one for one in fitting if not judged or not self._identity.is_strange(one.looks)]
        own = max(fitting, key=lambda one: self._identity.ratio(one.looks), default=None)
        return own, [one for one in found if one is not own]

    def _fits(self, rectangle: Rectangle, here: Pose) -> bool:
        x, y = self._state[:2].tolist()
        distance = here.distance_to(x, y)
        doubt = math.sqrt(float(np.linalg.eigvalsh(self._covariance[:2, :2])[-1])) + DISTANCE_SD * distance
        aside = rectangle.distance * abs(math.sin(rectangle.bearing - here.bearing_to(x, y)))
        return aside < 0.25 + min(0.3, doubt) and abs(rectangle.distance - distance) < 0.3 + doubt

    def _identify(self, own: Rectangle | None, others: Sequence[Rectangle], here: Pose) -> Rectangle | None:
        """Find out who is who in a picture: strangers, and the person at other legs → the person's rectangle."""
        elsewhere = self._known_elsewhere(own, others, here)
        strangers = [one for one in others if self._identity.is_strange(one.looks)]
        self._strangers = self._stamp, here, strangers if self._are_believed(own) else []
        return None if elsewhere else own

    def _known_elsewhere(self, own: Rectangle | None, others: Sequence[Rectangle], here: Pose) -> bool:
        """Take the legs of a walker for the person's where pictures show the person there and another, or nobody, at
        the person's place → whether they did.
        """
        stamp, identity = self._stamp, self._identity
        since, level = self._likely
        at_place = [own] if own is not None else [one for one in others if self._fits(one, here)]
        if at_place:
            before = level if stamp - since < LOOKS_MEMORY_S else SURE_RATIO
            level = before + NEWEST_SHARE * (max(identity.ratio(one.looks) for one in at_place) - before)
            self._likely = stamp, level
        elif stamp - since > LOOKS_MEMORY_S:
            self._likely = since, level = since, -math.inf if stamp - self.measured > MAX_HIDDEN_S else SURE_RATIO
        x, y = self._state[:2].tolist()
        for track in self._candidates(stamp):
            if _in_line(here, (x, y), track):
                continue
            there = [identity.ratio(one.looks) for one in others if _stands_on(one, track, here)]
            if there:
                track.is_stranger = max(there) < identity.least
                track.sights = track.sights + 1 if max(there) >= max(SURE_RATIO, level + RATIO_MARGIN) else 0
            if track.sights >= MIN_SIGHTS:
                self._take_over(track)
                return True
        return False

    def _are_believed(self, own: Rectangle | None) -> bool:
        """Return whether strangers near the person are: if the two may have been mixed up, and a picture shows the
        person beside them, or several showed a stranger in the person's place.
        """
        beside = own is not None and self._identity.ratio(own.looks) >= SURE_RATIO
        return self._identity.is_doubtful(self._stamp) and (beside or self._likely[1] < self._identity.least)

    def _take_over(self, track: LegTrack) -> None:
        self._others.remove(track)
        self._identity.doubt(self._stamp)
        self._likely, self._on_legs = (self._stamp, SURE_RATIO), self._stamp
        self._state = np.concatenate((track.place, track.velocity))
        self._covariance = np.diag([POSITION_SD**2, POSITION_SD**2, *2 * [self._tracking.walking**2]])

    def _moved_on(self, rectangle: Rectangle, passed: float, here: Pose) -> Rectangle:
        """The person's rectangle of a picture taken `passed` [s] ago → where it would be seen now."""
        return _placed_at(here, rectangle, np.array(_place_of(rectangle, here)) + passed * self._state[2:])

    def _excuse(self, camera: Camera, pose: Pose) -> None:
        """The camera cannot be blamed while it sees no more than legs where the person is."""
        here = eye(pose, camera)
        x, y = self._state[:2].tolist()
        bearing = here.bearing_to(x, y)
        self.only_legs = only_legs_show(camera, bearing, here.distance_to(x, y))
        if self.only_legs or off_axis(bearing, camera) > ASIDE_RAD:
            self._excused = self._stamp

    def _predict(self, stamp: float) -> None:
        passed = max(0.0, stamp - self._stamp)
        self._stamp = stamp
        if passed <= 0:
            return
        hidden = stamp - self.measured > MAX_HIDDEN_S
        if hidden:
            self._state[2:] *= math.exp(-passed / 1.0)  # who is out of sight may have stopped
        step = np.eye(4)
        step[:2, 2:] = passed * np.eye(2)
        self._state = step @ self._state
        jolt = np.array([[passed**3 / 3, passed**2 / 2], [passed**2 / 2, passed]])
        wander = self._tracking.acceleration**2 * STEADY_TIME_S
        self._covariance = step @ self._covariance @ step.T + wander * np.kron(jolt, np.eye(2))

    def _look(
        self, boards: VerticalPlanes, pose: Pose, standers: tuple[LegCluster, ...]
    ) -> tuple[Rectangle | None, list[Rectangle]]:
        """The person in the picture, and others who stand near there."""
        here = eye(pose, boards.camera)
        x, y = self._state[:2].tolist()
        if here.distance_to(x, y) < IN_VIEW or off_axis(here.bearing_to(x, y), boards.camera) > ASIDE_RAD:
            self._excused = self._stamp
        places = [self._state[:2], *(one.place for one in self._candidates(self._stamp))]
        found: list[Rectangle] = []
        for x, y in np.array(places).tolist():
            bearing, distance = here.bearing_to(x, y), here.distance_to(x, y)
            if distance < 0.3 or off_axis(bearing, boards.camera) > 0.7:
                continue
            seen = [from_eye(one, boards.camera) for one in standers]
            near = [far for far, angle in seen if abs(math.remainder(angle - bearing, math.tau)) < 0.5]
            hinted = [far for far in near if abs(far - distance) < 0.35 + 0.2 * distance]
            half = min(0.5, 0.12 + 0.35 / distance)
            planes = sorted(around([distance, *hinted]), key=lambda far: abs(far - distance))[:MAX_PLANES]
            found += find_people(boards, bearing, half, self._known, distances=planes)
        return self._own_among([replace(one, looks=_looks_of(boards, one)) for one in found], here)

    def _legs(
        self, stamp: float, pose: Pose, standers: tuple[LegCluster, ...], barred: tuple[LegCluster, ...]
    ) -> LegCluster | None:
        """The legs that the person walked on with; `barred`: those of strangers, as a picture shows."""
        place = pose.inverse().apply(self._state[None, :2])[0]
        if any(np.hypot(*(one.place - place)) < MISTAKEN_SD_M for one in barred):
            self._covariance[:2, :2] += MISTAKEN_SD_M**2 * np.eye(2)
            self._state[2:] = 0.0  # it is the other's speed
        expected = self._state[:2], self._covariance[:2, :2]
        limits = self._tracking.wide_gate, self._tracking.gate
        own = self._others.share_out(stamp, pose, standers, expected, limits, barred)
        if own is not None:
            self._on_legs = stamp
        elif (heir := self._others.heir(self._state[:2], stamp, self._tracking.wide_gate, self._on_legs)) is not None:
            self._take_over(heir)
        walkers = self._others.near(self._state[:2], stamp, walking=True)
        if any(self.apart_from(one.place) < NEAR_LEGS_M for one in walkers):
            self._identity.doubt(stamp)
        return own

    def _legs_of_strangers(
        self, standers: tuple[LegCluster, ...], pose: Pose, camera: Camera | None
    ) -> tuple[LegCluster, ...]:
        """Legs that a picture showed to be another's a moment ago."""
        since, before, strangers = self._strangers
        if camera is None or self._stamp - since > MAX_LEGS_AGE_S:
            return ()
        seen = [_seen_from(eye(pose, camera), one, before) for one in strangers]
        return tuple(one for one in standers if any(stands_at(one, other, camera) for other in seen))

    def _correct(
        self, stamp: float, pose: Pose, stander: LegCluster | None, rectangle: Rectangle | None, camera: Camera | None
    ) -> None:
        """Kalman's correction by the legs, then by the picture's bearing."""
        laser: Array | None = None
        ray: Ray | None = None
        used: list[Sense] = []
        if stander is not None:
            laser, spread = in_world(stander, pose)
            gain = self._covariance[:, :2] @ np.linalg.inv(self._covariance[:2, :2] + spread)
            self._state = self._state + gain @ (laser - self._state[:2])
            self._covariance = self._covariance - gain @ self._covariance[:2, :]
            used.append("laser")
        if rectangle is not None and camera is not None:
            ray = ray_of(rectangle, eye(pose, camera), pose)
            if self._see(rectangle, ray, alone=stander is None):
                used.append("camera")
            else:
                rectangle = ray = None
        if not used:
            self._hide()
            return
        if used == ["laser"] and stamp - max(self.pictured, self._excused) > self._tracking.unseen:
            self._hide()
            return
        fused = Fused(position=self._state[:2], covariance=self._covariance[:2, :2], used=tuple(used))
        self._tell(stamp, fused, rectangle, laser, ray, None)

    def _see(self, rectangle: Rectangle, ray: Ray, *, alone: bool) -> bool:
        """Correct by a rectangle: its bearing, without legs its distance too. Return whether it fits."""
        place, spread = self._state[:2], self._covariance[:2, :2]
        if alone:
            measured, doubt = along(ray, rectangle.distance, DISTANCE_SD * rectangle.distance)
            off = measured - place
            if off @ np.linalg.solve(spread + doubt, off) > self._tracking.gate:
                return False
            gain = self._covariance[:, :2] @ np.linalg.inv(spread + doubt)
            self._state = self._state + gain @ off
            self._covariance = self._covariance - gain @ self._covariance[:2, :]
            return True
        fused = fuse((place, spread), (("camera", ray),), None)
        if not fused.used:
            return False
        gain = np.linalg.solve(spread, self._covariance[:2, :]).T
        self._state = self._state + gain @ (fused.position - place)
        self._covariance = self._covariance - gain @ (spread - fused.covariance) @ gain.T
        return True

    def _hide(self) -> None:
        seen = self._seen
        assert seen is not None
        if self._stamp - self.measured > 0.3:
            seen = replace(seen, laser=None, camera=None, used=(), state="hidden")
        self._seen = replace(
            seen, position=self._state[:2], covariance=self._covariance[:2, :2], velocity=self._state[2:]
        )

    def _tell(
        self,
        stamp: float,
        fused: Fused,
        rectangle: Rectangle | None,
        laser: Array | None,
        camera: Ray | None,
        sound: Ray | None,
    ) -> None:
        before = self._seen
        self.measured = stamp
        if rectangle is not None:
            self.pictured = stamp
        self._seen = TrackedPerson(
            stamp=stamp,
            position=fused.position,
            covariance=fused.covariance,
            velocity=self._state[2:],
            rectangle=rectangle or (before.rectangle if before else None),
            rectangle_stamp=stamp if rectangle else (before.rectangle_stamp if before else -math.inf),
            laser=laser if laser is not None else (before.laser if before and rectangle is not None else None),
            camera=camera or (before.camera if before else None),
            sound=sound or (before.sound if before else None),
            used=fused.used,
        )


def _towards(call: VoiceBearing, pose: Pose) -> tuple[float, float]:
    """A voice → its bearing [rad, robot frame], and the sd [rad] of where its person stands."""
    return math.remainder(call.azimuth - pose.heading, math.tau), math.hypot(call.sd, 0.02)


def _seen_from(here: Pose, rectangle: Rectangle, before: Pose) -> Rectangle:
    """A rectangle that was seen from a camera `before` → as it is seen from `here`."""
    return _placed_at(here, rectangle, np.array(_place_of(rectangle, before)))


def _placed_at(here: Pose, rectangle: Rectangle, place: Array) -> Rectangle:
    """A rectangle → the same of a person who stands at a place (2,) [m], world, seen from `here`."""
    x, y = place.tolist()
    return replace(rectangle, bearing=here.bearing_to(x, y), distance=max(here.distance_to(x, y), 0.1))


def _place_of(rectangle: Rectangle, here: Pose) -> tuple[float, float]:
    """Place (x, y) [m], world, of a person seen from `here`."""
    azimuth = here.heading + rectangle.bearing
    return here.x + rectangle.distance * math.cos(azimuth), here.y + rectangle.distance * math.sin(azimuth)


def _in_line(here: Pose, place: tuple[float, float], track: LegTrack) -> bool:
    """Return whether people there and at these legs hide each other: then no picture can tell who is where."""
    x, y = track.place.tolist()
    apart = abs(math.remainder(here.bearing_to(*place) - here.bearing_to(x, y), math.tau))
    return min(here.distance_to(*place), here.distance_to(x, y)) * apart < LEGS_BESIDE_M


def _stands_on(rectangle: Rectangle, track: LegTrack, here: Pose) -> bool:
    x, y = track.place.tolist()
    aside = rectangle.distance * abs(math.sin(rectangle.bearing - here.bearing_to(x, y)))
    return (
        aside < LEGS_BESIDE_M
        and abs(rectangle.distance - here.distance_to(x, y)) < 0.2 + DISTANCE_SD * rectangle.distance
    )


def _looks_of(boards: VerticalPlanes, rectangle: Rectangle) -> Appearance:
    return colours_seen(boards, rectangle.distance, rectangle.bearing, rectangle.height)
