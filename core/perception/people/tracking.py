"""Following one person over time: laser legs and pictures against a prediction that outlives short occlusions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.perception.people.appearance import Appearance, PersonProfile, alike, colours_seen, remembered
from core.perception.people.brightness import levelled
from core.perception.people.camera_geometry import (
    around,
    axis,
    eye,
    from_eye,
    in_world,
    legs_of,
    on_legs,
    ray_of,
    stands_at,
)
from core.perception.people.detector import Rectangle, find_people
from core.perception.people.fusion import Fused, Ray, Sense, along, fuse
from core.perception.people.leg_tracks import OtherLegs
from core.perception.people.legs import LegCluster, find_standers
from core.perception.people.looking import PersonLook
from core.perception.people.parts import PeopleSettings
from core.perception.people.person_pictures import AnsweredPicture, PersonPictures, only_legs_show
from core.perception.people.search import PLANES, Glance, Search
from core.perception.people.tracked_person import TrackedPerson, TrackSettings
from core.perception.people.vertical_plane import VerticalPlanes
from core.perception.people.voice_bearing import VoiceBearing
from core.sensors import Camera, Image

DISTANCE_SD = 0.15  # share of a distance that only the picture gives
IN_VIEW, ASIDE = 1.3, 0.4  # [m], [rad] nearer or farther aside, too little of a person is in the picture
MISTAKEN = 0.3  # [m] sd that is added where a picture shows that the legs at the person's place are another's
STEADY = 0.5  # [s] for which a person's acceleration lasts


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
        self._looks: Appearance | None = None  # since they were locked on
        self._pictures = 0
        self.strangers = False  # a person was seen where the voice came from, but not the one searched for
        self.measured = -math.inf  # [s]
        self.pictured = -math.inf  # [s] when a picture showed the person
        self.looked = -math.inf  # [s] when a picture came at all
        self.only_legs = False  # the person is so near that the camera sees no more of them: the laser decides
        self._excused = -math.inf  # [s] when no picture could have shown enough of the person
        self._seen: TrackedPerson | None = None
        self._scanned = -math.inf  # [s] of the newest scan
        self._glance: Glance | None = None
        self._others = OtherLegs()

    @property
    def person(self) -> TrackedPerson | None:
        """The followed person; None before one was found."""
        return self._seen if self._pictures >= self._tracking.births else None

    def apart_from(self, place: Array) -> float:
        """Distance [m] of the person from a place (2,) [m], world."""
        return float(np.hypot(*(self._state[:2] - place)))

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
        self.strangers |= glance.search.strangers
        for rectangle in found:
            ray = ray_of(rectangle, eye(glance.pose, camera), glance.pose)
            stander = legs_of(rectangle, glance.standers, camera, self._settings)
            if rectangle.shown < self._settings.enough and not on_legs(rectangle, stander, self._settings):
                continue
            self._first(call, glance.stamp, glance.pose, ray, rectangle, stander)
            self._looks = remembered(_looks_of(glance.search.boards, rectangle), self._looks)
            return

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
            sd = math.hypot(call.sd, 0.02)
            bearing = math.remainder(call.azimuth - pose.heading, math.tau)
            asked.ask_towards(image, camera, pose, find_standers(points), (bearing, sd), stamp)
        answered = asked.answer()
        if answered is None:
            return
        for rectangle in answered.found:
            if not self._is_who(rectangle):
                self.strangers = True
                continue
            ray = ray_of(rectangle, eye(answered.pose, camera), answered.pose)
            stander = legs_of(rectangle, answered.standers, camera, self._settings)
            self._first(call, answered.stamp, answered.pose, ray, rectangle, stander)
            if rectangle.looks is not None:
                self._looks = remembered(rectangle.looks, self._looks)
            return
        if answered.legs is not None and self._who is None:
            self._first(call, answered.stamp, answered.pose, None, None, answered.legs)

    def _is_who(self, rectangle: Rectangle) -> bool:
        """Return whether this may be the person who is searched for."""
        if self._who is None or rectangle.looks is None:
            return self._who is None
        return alike(self._who.looks, rectangle.looks) >= self._settings.alike

    def _looking(
        self, call: VoiceBearing, stamp: float, pose: Pose, points: Array, image: Image, camera: Camera
    ) -> Glance:
        """A picture that is to be looked through."""
        wedge = math.hypot(call.sd, 0.02) * self._settings.wedge
        bearing = math.remainder(call.azimuth - pose.heading, math.tau)
        standers = find_standers(points)
        seen = [from_eye(one, camera) for one in standers]
        near = [far for far, angle in seen if abs(math.remainder(angle - bearing, math.tau)) < wedge + 0.3 / far]
        boards = VerticalPlanes(levelled(image.pixels), camera)
        least = min(self._settings.threshold_of_feet, self._settings.feet_with_legs)
        settings = replace(self._settings, threshold_of_feet=least)
        search = Search(boards, (bearing, wedge), near, settings, self._who)
        return Glance(search, stamp, pose, standers)

    def follow(
        self,
        stamp: float,
        pose: Pose,
        points: Array,
        scanned: float,
        image: Image | None,
        camera: Camera | None,
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
        barred: tuple[LegCluster, ...] = ()
        boards: VerticalPlanes | None = None
        if image is not None:
            self.looked = stamp
        if camera is None:
            self._excused = stamp  # nothing looks there, so that no picture can show the person
        elif self._asked is not None:
            self._excuse(camera, pose)
            rectangle, barred = self._follow_with(self._asked, stamp, pose, standers, image, camera)
        elif image is not None:
            boards = VerticalPlanes(levelled(image.pixels), camera)
            rectangle, strangers = self._look(boards, pose, standers)
            barred = _legs_of_strangers(standers, strangers, camera)
        if fresh_scan or rectangle is not None:
            stander = self._legs(stamp, pose, standers, barred)
        self._correct(stamp, pose, stander, rectangle, camera)
        if rectangle is not None:
            self._remember(boards, rectangle)

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
    ) -> tuple[Rectangle | None, tuple[LegCluster, ...]]:
        """Ask for the person where they are expected → the person in the newest answer, and legs of others."""
        here = eye(pose, camera)
        x, y = self._state[:2].tolist()
        bearing, distance = here.bearing_to(x, y), here.distance_to(x, y)
        if image is not None and distance > 0.3:
            across = math.sqrt(float(np.linalg.eigvalsh(self._covariance[:2, :2])[-1]))
            sd = min(0.3, math.hypot(0.02, across / distance))
            asked.ask_for(image, camera, pose, standers, (bearing, sd), distance, stamp)
        answered = asked.answer()
        if answered is None:
            return None, ()
        own: Rectangle | None = None
        strangers: list[Rectangle] = []
        for one in answered.found:
            if self._is_followed(one):
                own = own or self._moved_on(one, stamp - answered.stamp, answered, camera, pose)
            else:
                strangers.append(one)
        return own, _legs_of_strangers(standers, strangers, camera)

    def _is_followed(self, rectangle: Rectangle) -> bool:
        """Return whether these may be the looks of the person who is followed."""
        if self._looks is None or rectangle.looks is None:
            return True
        return alike(self._looks, rectangle.looks) >= self._tracking.alike

    def _moved_on(
        self, rectangle: Rectangle, passed: float, answered: AnsweredPicture, camera: Camera, pose: Pose
    ) -> Rectangle:
        """A rectangle of a picture taken `passed` [s] ago → where it would be seen now: both moved meanwhile."""
        then = eye(answered.pose, camera)
        azimuth = answered.pose.heading + rectangle.bearing
        x = then.x + rectangle.distance * math.cos(azimuth) + passed * float(self._state[2])
        y = then.y + rectangle.distance * math.sin(azimuth) + passed * float(self._state[3])
        here = eye(pose, camera)
        return replace(rectangle, bearing=here.bearing_to(x, y), distance=max(here.distance_to(x, y), 0.1))

    def _excuse(self, camera: Camera, pose: Pose) -> None:
        """The camera cannot be blamed while it sees no more than legs where the person is."""
        here = eye(pose, camera)
        x, y = self._state[:2].tolist()
        bearing = here.bearing_to(x, y)
        self.only_legs = only_legs_show(camera, bearing, here.distance_to(x, y))
        if self.only_legs or abs(bearing - axis(camera)) > ASIDE:
            self._excused = self._stamp

    def _predict(self, stamp: float) -> None:
        passed = max(0.0, stamp - self._stamp)
        self._stamp = stamp
        if passed <= 0:
            return
        hidden = stamp - self.measured > 0.5
        if hidden:
            self._state[2:] *= math.exp(-passed / 1.0)  # who is out of sight may have stopped
        step = np.eye(4)
        step[:2, 2:] = passed * np.eye(2)
        self._state = step @ self._state
        jolt = np.array([[passed**3 / 3, passed**2 / 2], [passed**2 / 2, passed]])
        wander = self._tracking.acceleration**2 * STEADY
        self._covariance = step @ self._covariance @ step.T + wander * np.kron(jolt, np.eye(2))

    def _look(
        self, boards: VerticalPlanes, pose: Pose, standers: tuple[LegCluster, ...]
    ) -> tuple[Rectangle | None, list[Rectangle]]:
        """The person in the picture, and others who stand near there."""
        camera = boards.camera
        here = eye(pose, camera)
        bearing = here.bearing_to(float(self._state[0]), float(self._state[1]))
        distance = here.distance_to(float(self._state[0]), float(self._state[1]))
        if distance < IN_VIEW or abs(bearing - axis(camera)) > ASIDE:
            self._excused = self._stamp
        if distance < 0.3 or abs(bearing - axis(camera)) > 0.7:
            return None, []
        near = [far for far, angle in (from_eye(one, camera) for one in standers) if abs(angle - bearing) < 0.5]
        hinted = [far for far in near if abs(far - distance) < 0.35 + 0.2 * distance]
        half = min(0.5, 0.12 + 0.35 / distance)
        planes = sorted(around([distance, *hinted]), key=lambda far: abs(far - distance))[:PLANES]
        found = find_people(boards, bearing, half, self._known, distances=planes)
        doubt = math.sqrt(float(np.linalg.eigvalsh(self._covariance[:2, :2])[-1])) + DISTANCE_SD * distance
        own: Rectangle | None = None
        strangers: list[Rectangle] = []
        for one in found:
            aside = one.distance * abs(math.sin(one.bearing - bearing))
            if self._looks is not None and alike(self._looks, _looks_of(boards, one)) < self._tracking.alike:
                strangers.append(one)
            elif own is None and aside < 0.25 + min(0.3, doubt) and abs(one.distance - distance) < 0.3 + doubt:
                own = one
        return own, strangers

    def _legs(
        self, stamp: float, pose: Pose, standers: tuple[LegCluster, ...], barred: tuple[LegCluster, ...]
    ) -> LegCluster | None:
        """The legs that the person walked on with; `barred`: those of strangers, as a picture shows."""
        place = pose.inverse().apply(self._state[None, :2])[0]
        if any(np.hypot(*(one.place - place)) < MISTAKEN for one in barred):
            self._covariance[:2, :2] += MISTAKEN**2 * np.eye(2)
        expected = self._state[:2], self._covariance[:2, :2]
        limits = self._tracking.wide_gate, self._tracking.gate
        return self._others.share_out(stamp, pose, standers, expected, limits, barred)

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
        """Nothing new: where they are by the prediction."""
        seen = self._seen
        assert seen is not None
        gone = self._stamp - self.measured > 0.3
        self._seen = TrackedPerson(
            stamp=seen.stamp,
            position=self._state[:2],
            covariance=self._covariance[:2, :2],
            velocity=self._state[2:],
            rectangle=seen.rectangle,
            rectangle_stamp=seen.rectangle_stamp,
            laser=None if gone else seen.laser,
            camera=None if gone else seen.camera,
            sound=seen.sound,
            used=() if gone else seen.used,
            state="hidden" if gone else "seen",
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

    def _remember(self, boards: VerticalPlanes | None, rectangle: Rectangle) -> None:
        seen = rectangle.looks if boards is None else _looks_of(boards, rectangle)
        if seen is not None:
            self._looks = remembered(seen, self._looks)


def _legs_of_strangers(
    standers: tuple[LegCluster, ...], strangers: Sequence[Rectangle], camera: Camera
) -> tuple[LegCluster, ...]:
    return tuple(one for one in standers if any(stands_at(one, other, camera) for other in strangers))


def _looks_of(boards: VerticalPlanes, rectangle: Rectangle) -> Appearance:
    return colours_seen(boards, rectangle.distance, rectangle.bearing, rectangle.height)
