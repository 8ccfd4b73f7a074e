"""The gate's logic: from setpoints that may be late, repeated or malformed to a twist.

No clock, no thread, no file: every call brings the time `now` [s] of one steady clock. `tick`, every 20 ms, is the
only source of motion. A setpoint counts for a quarter of a second, only under the lease that is in force, and only
if it returns a nonce that the gate gave out less than `nonce_age` ago: so the age of the setpoint itself is
bounded, whatever was buffered on its way. After every stop, what was pressed then never moves the robot again.
"""

import math
from collections.abc import Iterable, Sequence

from core.gate.deadman import Deadman
from core.gate.guard import ObstacleGuard, Permitted
from core.gate.limits import Limits, is_count, is_number, speed_cap
from core.gate.setpoint import AcceptedSetpoint, HeldCommand, Setpoint, Source
from core.gate.status import BUSY, EXPIRED, GATE_LATE, GateStatus, State
from core.gate.trace import Event, TraceWriter
from core.gate.twist import ZERO, Twist
from core.sentences import Statement


class Nonces:
    """Rising numbers that give the age of a setpoint, for a while after each was given out, by the gate's clock."""

    def __init__(self, first: int, lifetime: float) -> None:
        self.newest = first
        self._lifetime = lifetime  # [s]
        self._issued: dict[int, float] = {}
        self._marked = first

    def issue(self, now: float) -> None:
        """Give out the next one, and forget those that have expired."""
        self.newest += 1
        self._issued[self.newest] = now
        while now - self._issued[oldest := next(iter(self._issued))] > self._lifetime:
            del self._issued[oldest]

    def age(self, nonce: int, now: float) -> float | None:
        """Its age [s]; None when it has expired or was never given out."""
        issued = self._issued.get(nonce)
        return None if issued is None or now - issued > self._lifetime else max(now - issued, 0.0)

    def mark(self, now: float) -> None:
        """Draw a line: nonces given out until now are `before` it, a new one follows at once."""
        self._marked = self.newest
        self.issue(now)

    def is_after_mark(self, nonce: int) -> bool:
        """Return whether a nonce was given out after the newest mark."""
        return nonce > self._marked


MAX_REMEMBERED_PRESSES = 4096


class Presses:
    """One present press, of a key or a goal, per source; what was stopped, replaced or overridden never counts."""

    def __init__(self, over: Iterable[tuple[str, int]] = ()) -> None:
        self._present: dict[str, int] = {}
        self._over: dict[tuple[str, int], None] = dict.fromkeys(over)

    def begin(self, source: str, press: int) -> bool:
        """Make it the present one of its source, whose former one is over → False when it is over itself."""
        if (source, press) in self._over:
            return False
        if self._present.get(source, press) != press:
            self.end(source)
        self._present[source] = press
        return True

    def end(self, source: str) -> None:
        """End the present press of a source."""
        if source in self._present:
            self.refuse(source, self._present[source])

    def end_all(self) -> None:
        """End every present press."""
        for source in self._present:
            self.end(source)

    def refuse(self, source: str, press: int) -> None:
        """Mark this press as over, present or not. The oldest of very many are forgotten."""
        self._over[source, press] = None
        if len(self._over) > MAX_REMEMBERED_PRESSES:
            del self._over[next(iter(self._over))]


TICK_S = 0.02  # between ticks
LATE_TICK_S = 0.1  # between ticks after which the gate does not trust itself
HOLD_S = 2.0  # [s] for which a command waits that a busy computer does not steer
STEADY_S = 0.2  # [s] of unbroken heartbeat before it goes on: a stop that waited in the console comes first
MAX_BLIND_S = 1.0  # without a scan after which standing becomes a trip
TROUBLE_HELD_S = 0.3  # for which the robot's word that it cannot be driven counts


class Gate:
    """The one way to the wheels. Begins disarmed, or halted if it was; `spent` presses never move it."""

    def __init__(
        self,
        limits: Limits,
        *,
        halted: bool = False,
        trace: TraceWriter | None = None,
        first_nonce: int = 1,
        spent: Iterable[tuple[str, int]] = (),
    ) -> None:
        self.limits = limits
        self._trace = trace
        self._guard = ObstacleGuard(limits)
        self._deadman = Deadman(limits)
        self._state: State = "halted" if halted else "disarmed"
        self._reason = Statement("gate.reason_halted_before") if halted else ""
        self._remark = ""  # on the halt that is in force
        self._epoch, self._owner = 0, ""
        self._accepted: AcceptedSetpoint | None = None
        self._held: HeldCommand | None = None
        self._twist = ZERO
        self._permitted = Permitted(ZERO)
        self._refused = ""
        self._nonces = Nonces(first_nonce, limits.nonce_age)
        self._last_seq: dict[str, int] = {}
        self._presses = Presses(spent)
        self._need_neutral = True
        self._trips = 0
        self._ticked: float | None = None
        self._set_at = -math.inf  # when `_twist` was last set
        self._seen = self._heard = -math.inf  # [s]: when what was seen was measured; when the robot was last heard of
        self._age, self._untimely = 0.0, (0.0, -math.inf)  # [s] of the newest scan; of one left out for it, and when
        self._troubled = -math.inf  # [s] when the robot last said that it cannot be driven
        self._contact, self._contact_side, self._side = False, 0.0, 0.0
        self._cap = math.inf  # [m/s] where the robot is

    # what is asked

    def accept(self, setpoint: Setpoint, now: float) -> str:
        """Judge one setpoint → "" when it is in force now, else the reason in words."""
        self._refused = self._judge(setpoint, now)
        return self._refused

    def arm(self, epoch: object, owner: str, now: float) -> str:
        """Accept setpoints under this lease from now on, starting at zero → "" or why not."""
        if self._state == "halted":
            return Statement("gate.halted_first")
        if not is_count(epoch) or epoch < self._epoch:
            return "An older lease cannot be armed."
        if epoch == self._epoch and self._owner not in ("", owner):
            return "One lease has one holder: another holder needs a higher epoch."
        if self._state == "armed" and (epoch, owner) == (self._epoch, self._owner):
            return ""
        if epoch != self._epoch:
            self._last_seq.clear()
        self._state, self._epoch, self._owner = "armed", epoch, owner
        self._stand("arm", "", now)
        return ""

    def disarm(self, now: float, reason: str = "") -> None:
        """Accept no setpoint."""
        if self._state == "armed":
            self._state = "disarmed"
        self._stand("disarm", reason, now)

    def cap(self, speed: float | None) -> None:
        """Move no faster than `speed` [m/s], and never faster than the limits, from now on; None: as they say."""
        self._cap = math.inf if speed is None else max(speed, 0.0)

    def stop(self, now: float) -> None:
        """Set zero at once; the present press never moves the robot again, a new press may."""
        self._stand("stop", "stopped", now)

    def halt(self, now: float) -> None:
        """Set zero at once; nothing moves until `reset` and a new `arm`."""
        self._state, self._remark = "halted", ""
        self._stand("halt", "halted", now)

    def wake(self, now: float) -> None:
        """Trip after a sleep of the machine, in which the clock stood still: every earlier setpoint is over."""
        self._trip(Statement("gate.reason_slept"), now)

    def reset(self, now: float) -> None:
        """Lift a halt: disarmed then, and still."""
        if self._state == "halted":
            self._state = "disarmed"
            self._stand("reset", "", now)

    def remark(self, reason: str) -> None:
        """Set a reason for the status: as long as a halt lasts, else until the next motion or stop."""
        self._reason = self._remark = reason

    # what is known

    def see(self, points: Sequence[Sequence[float]], now: float, field: float = math.pi, age: float = 0.0) -> None:
        """Take near scan points (x, y) [m], robot frame, up to `field` [rad] to either side, measured `age` [s] ago.

        What is seen is dated by its measurement: it counts until `limits.scan_age` from then.
        """
        self._heard = now
        if age > self.limits.scan_age:
            self.see_untimely(age, now)
            return
        self._guard.see(points, field, age)
        self._seen, self._age = max(self._seen, now - max(age, 0.0)), max(age, 0.0)

    def see_untimely(self, age: float, now: float) -> None:
        """Take that the newest scan is `age` [s] old, or stamped so far ahead (< 0): too much to drive by."""
        self._untimely = age, now

    def see_trouble(self, now: float) -> None:
        """Take that the robot cannot be driven now, as its driver says: whatever moves it trips."""
        self._troubled = now

    def touch(self, contact: bool, now: float) -> None:
        """Take the bumper's state; the robot is alive. A new contact trips; only the other direction leads out."""
        self._heard = now
        if contact and not self._contact:
            self._contact_side = self._side
            if self._accepted is not None:
                self._trip(Statement("gate.reason_bumper"), now)
        self._contact = contact

    def heartbeat(self, now: float) -> None:
        """Note that the console is alive."""
        self._deadman.heartbeat(now)

    def status(self) -> GateStatus:
        """Return the gate's status now."""
        permitted = self._permitted
        return GateStatus(
            state=self._state,
            reason=permitted.reason or self._reason,
            epoch=self._epoch,
            owner=self._owner,
            nonce=self._nonces.newest,
            v=self._twist.v,
            w=self._twist.w,
            source=self._accepted.source if self._accepted else "",
            limit_v=permitted.limit,
            blocked_by=permitted.point,
            need_neutral=self._need_neutral,
            trips=self._trips,
            holds=self._held is not None,
            refused=self._refused,
        )

    @property
    def nonce(self) -> int:
        """The newest nonce."""
        return self._nonces.newest

    @property
    def twist(self) -> Twist:
        """The twist of the wheels now; a stop shows here at once, before the next tick."""
        return self._twist

    @property
    def expires(self) -> float:
        """Time [s] at which the setpoint ends unless a new one or a heartbeat comes; a tick is due then, too."""
        if self._accepted is None:
            return math.inf
        return self._deadman.expires(self._accepted.arrived)

    # what follows

    def tick(self, now: float) -> Twist:
        """Advance by one tick, every 20 ms → the twist of the wheels."""
        if self._is_before_the_last_tick(now):  # what was noted has a time that is yet to come
            self._seen = self._heard = self._troubled = -math.inf
            self._nonces.mark(now)
        if self._accepted is not None and (trouble := self._trouble(self._accepted, now)):
            if self._accepted.source == "goal" and trouble in BUSY and now - (self._ticked or now) < HOLD_S:
                self._hold(self._accepted.press, trouble, now)
            else:
                self._trip(trouble, now)
        elif self._held is not None and now > self._held.until:
            self._trip(self._held.reason, now)
        self._ticked = now
        self._set_twist(self._permit(min(max(now - self._set_at, 0.0), LATE_TICK_S), now), now)
        self._nonces.issue(now)
        self._write("", now)
        return self._twist

    def _is_before_the_last_tick(self, now: float) -> bool:
        return self._ticked is not None and now < self._ticked

    def _trouble(self, accepted: AcceptedSetpoint, now: float) -> str:
        """Return why the setpoint in force must end, "" if it need not."""
        if self._is_before_the_last_tick(now):
            return "the gate's clock ran backwards"
        if self._ticked is not None and now - self._ticked > LATE_TICK_S:
            return GATE_LATE
        if silence := self._deadman.trouble(accepted.arrived, now):
            return silence
        if now - self._troubled <= TROUBLE_HELD_S:
            return Statement("gate.reason_trouble")
        if self._untimely_age(now) > MAX_BLIND_S or MAX_BLIND_S < now - self._last_sign < math.inf:
            return (
                self._blindness(now) or Statement("gate.reason_no_scan")
                if self.limits.guard
                else Statement("gate.reason_silent")
            )
        return ""

    def _untimely_age(self, now: float) -> float:
        """Age [s] of the scans that come and are left out for it; 0: none is."""
        age, at = self._untimely
        return age if self._seen < at and now - at <= MAX_BLIND_S and self.limits.guard else 0.0

    def _blindness(self, now: float) -> str:
        """Why the scans that come are not driven by, in words; "" where none comes."""
        age = self._untimely_age(now)
        if age < 0.0:
            return Statement("gate.reason_laser_ahead", lead=f"{-age:.1f}")
        return Statement("gate.reason_laser_late", age=f"{age:.1f}") if age > 0.0 else ""

    @property
    def _last_sign(self) -> float:
        """Time [s] of the newest reading that shows the robot's motion or surroundings."""
        return self._seen if self.limits.guard else self._heard

    def _permit(self, elapsed: float, now: float) -> Permitted:
        """The setpoint in force → the part of it that is permitted after `elapsed` seconds more."""
        if self._accepted is None:
            return Permitted(ZERO)
        if now - self._last_sign > self.limits.scan_age:
            waits = self._blindness(now) or Statement("gate.reason_waits_scan")
            return Permitted(ZERO, 0.0, None, waits if self.limits.guard else Statement("gate.reason_silent"))
        wanted = self._accepted.twist
        if self._contact and wanted.v * self._contact_side > 0.0:
            return Permitted(ZERO, 0.0, None, "the bumper touches something: drive away from it")
        limits = self.limits
        cap = min(speed_cap(limits, max(self._accepted.age, self._age)), self._cap)
        if limits.guard and wanted.v < 0.0:
            cap = min(cap, self._guard.backing_speed)
        wanted = wanted.clamped(cap, limits.max_turn_rate)
        twist = self._twist.towards(wanted, limits.max_acceleration * elapsed, limits.max_turn_acceleration * elapsed)
        permitted = self._guard.permit(twist) if limits.guard else Permitted(twist)
        if permitted.limit is None and cap < limits.max_speed:
            return Permitted(permitted.twist, cap)
        return permitted

    def _judge(self, setpoint: Setpoint, now: float) -> str:
        if not setpoint.is_well_formed:
            return "The setpoint is malformed."
        if self._state != "armed":
            return Statement("gate.robot_halted") if self._state == "halted" else Statement("gate.not_armed")
        if setpoint.epoch != self._epoch:
            return "Stale: another lease is in force."
        if setpoint.seq <= self._last_seq.get(setpoint.source, -1):
            return "Stale: a newer setpoint came before it."
        self._last_seq[setpoint.source] = setpoint.seq
        age = self._nonces.age(setpoint.nonce, now)
        if age is None:
            return EXPIRED
        if not (is_number(setpoint.v) and is_number(setpoint.w)):
            self._trip("a speed that is not a number", now)
            return "A speed is not a finite number."
        after_stop = self._nonces.is_after_mark(setpoint.nonce)
        if setpoint.source == "goal":
            self._presses.begin("goal", setpoint.press)
        if setpoint.v == 0.0 and setpoint.w == 0.0:
            return self._rest(setpoint.source, after_stop, now)
        if not after_stop:
            return "It was sent before the robot was stopped."
        return self._obey(setpoint, age, now)

    def _rest(self, source: Source, after_stop: bool, now: float) -> str:
        """Take a zero setpoint: no ramp, and the hand has let go; a command that was held is steered again."""
        if source == "goal" and after_stop and self._may_resume(now):
            self._held = None
        if source == "jog" and after_stop:
            self._need_neutral = False
        if self._accepted is not None and self._accepted.source == source:
            self._accepted = None
            self._set_twist(Permitted(ZERO), now)
            self._write("", now)
        return ""

    def _obey(self, setpoint: Setpoint, age: float, now: float) -> str:
        source, press = setpoint.source, setpoint.press
        if self._deadman.console_silent(now):
            return "The console's heartbeat is missing."
        over = Statement("gate.stopped_press_again") if source == "jog" else Statement("gate.stopped_new_command")
        driven = self._accepted is not None and self._accepted.source == "jog"
        if (source == "jog" and self._need_neutral) or (source == "goal" and driven):
            self._presses.refuse(source, press)
            over = Statement("gate.let_go_first") if source == "jog" else Statement("gate.hand_drives")
        if not self._presses.begin(source, press):
            return over
        if source == "jog":
            self._presses.end("goal")
        elif self._held is not None and self._held.press == press and not self._may_resume(now):
            return Statement("gate.silence_over")
        self._held = None
        self._accepted = AcceptedSetpoint(Twist(setpoint.v, setpoint.w), source, press, now, age)
        self._reason = ""
        return ""

    def _may_resume(self, now: float) -> bool:
        """Return whether what was held may go on: whatever waited in the console, a stop too, was sent before."""
        return self._deadman.steady_for(now) >= STEADY_S

    def _hold(self, press: int, reason: str, now: float) -> None:
        """Set zero; the command may go on with setpoints made from now on, unless anything else stops it."""
        self._presses.end("jog")
        self._held = HeldCommand(press, now + HOLD_S, reason)
        self._accepted, self._need_neutral, self._reason = None, True, reason
        self._set_twist(Permitted(ZERO), now)
        self._nonces.mark(now)
        self._write("hold", now)

    def _trip(self, reason: str, now: float) -> None:
        self._trips += 1
        self._stand("trip", reason, now)

    def _stand(self, event: Event, reason: str, now: float) -> None:
        """Set zero; no earlier press moves the robot again; a new nonce separates later setpoints from earlier."""
        self._presses.end_all()
        self._accepted, self._held, self._refused = None, None, ""
        self._set_twist(Permitted(ZERO), now)
        self._need_neutral = True
        self._reason = self._remark or "halted" if self._state == "halted" else reason
        self._nonces.mark(now)
        self._write(event, now)

    def _set_twist(self, permitted: Permitted, now: float) -> None:
        if self._twist.moves:
            self._guard.roll(self._twist, min(max(now - self._set_at, 0.0), LATE_TICK_S))
        self._permitted, self._twist, self._set_at = permitted, permitted.twist, now
        if self._twist.v != 0.0:
            self._side = math.copysign(1.0, self._twist.v)

    def _write(self, event: Event, now: float) -> None:
        if self._trace is not None:
            status, press = self.status(), self._accepted.press if self._accepted else 0
            self._trace.write(status, press, event, now)
