"""The one entrance for commands from any source: typed, clicked, REST, teleoperation (jog) by keys or stick.

Who may, whether a robot is there, whether the latch is off, who drives: checked here and nowhere else. Words that
were typed are understood here; a recognizer's words arrive as commands. Everything runs on the event loop and none of
it waits.
"""

import math
import time
from collections.abc import Callable, Container, Sequence
from dataclasses import replace
from typing import Literal

from console.access.logins import Person
from console.control import lease as leases
from console.control.active_commands import ActiveCommand, ActiveCommands, ActiveJog
from console.control.command_freshness import CommandFreshness, Spoken
from console.control.history import History, row_of
from console.control.history_store import HistoryEntry
from console.control.lease import Lease
from console.control.notices import Notifications
from console.control.stop import StopController
from console.http.problems import Problem, problem_of
from console.messages import inbound
from console.robot.setpoint_sender import SetpointSender
from console.robot.supervisor import RobotSupervisor
from core.commands import spec_of
from core.commands.command import Command
from core.commands.stop_moving import STOP_MOVING
from core.errors import Refused
from core.gate.status import GateStatus
from core.perception.people.voice_bearing import VoiceBearing
from core.pilot.pilot import Pilot
from core.sentences import Statement
from core.snapshot import ActiveCommandStatus, Ending
from core.speech.understanding.grammar import OwnPhrases, Refusal, understand

VIEWERS_WATCH = Statement("command.viewers_watch")

REACHED = ("live", "stale")
LeaseAction = Literal["acquire", "renew", "take", "release", "ask", "give", "keep"]
SETTLING_S = 0.3  # after which what the gate says surely concerns a command
MAX_TICK_GAP_S = 1.0  # between two ticks after which what came meanwhile came at nobody knows what time
LET_GO_PAUSE_S = 0.5  # without a moving jog after which the press has ended


class CommandDispatcher:
    def __init__(
        self,
        robot: RobotSupervisor,
        lease: Lease,
        history: History,
        notifications: Notifications,
        own: OwnPhrases = (),
    ) -> None:
        """`own`: phrases of the user's that may be typed, too."""
        self.own_phrases = own
        self._places: OwnPhrases = ()
        self.hand_warning: Callable[[inbound.JogMessage], str] = lambda _: ""
        """Asked before a hand moves the robot: why that press must not, "" for no reason."""
        self.handlers: dict[str, Callable[[Command, Person], object]] = {}
        """Commands that a part of the console carries out, by their names."""
        self._warned_press: int | None = None
        self.setpoint_sender = SetpointSender(robot)
        self._stop_controller = StopController(
            robot, self.setpoint_sender, lease, history, notifications, self.cancel
        )
        self.pilot: Pilot | None = None  # None: it failed
        self.when_cancelled: list[Callable[[Ending, str, bool], None]] = []  # called when the active command ends
        self._robot = robot
        self._lease = lease
        self._history = history
        self._notifications = notifications
        self.freshness = CommandFreshness(lease)
        self._active = ActiveCommands()
        self._jog: ActiveJog | None = None
        self._trips, self._tripped = 0, 0.0  # how often the gate stopped by itself, and when [s] it last did
        self._closed = False  # the console is ending
        self._ticked = math.inf  # [s]
        self._obeyed = 0.0  # [s] when the gate last had nothing against the active command

    @property
    def phrases(self) -> OwnPhrases:
        """All words that are understood beside the vocabulary: the user's own, and those of named places."""
        return (*self.own_phrases, *self._places)

    def know_places(self, phrases: OwnPhrases) -> None:
        """Understand these words of places from now on, and no others."""
        self._places = phrases

    # commands

    def submit(
        self, text: str, source: str, who: Person, said: Spoken | None = None, call: VoiceBearing | None = None
    ) -> HistoryEntry:
        """Understand words as they arrive → the history entry of the command that is now active; `said`: when they
        were, if that was not this moment; `call`: where the person is whom they concern. Raises Problem 403 to 503.
        """
        heard = understand(text, own=self.phrases)
        if call is not None and isinstance(heard, Command):
            if spec_of(heard.name).target != "person":
                raise Problem(422, Statement("command.only_to_persons"))
            heard = replace(heard, call=call)
        return self.accept(heard, text, source, who, said)

    def accept(
        self, heard: Command | Refusal, words: str, source: str, who: Person, said: Spoken | None = None
    ) -> HistoryEntry:
        """Dispatch what was understood, or record its refusal. Raises Problem 422, 403 to 503."""
        if isinstance(heard, Refusal):
            self._history.add("command", who, state="refused", remark=heard.reason, source=source, words=words)
            suggestions = list(heard.suggestions)
            raise Problem(422, heard.reason, more={"reason": heard.reason, "suggestions": suggestions})
        return self.dispatch(heard, source, who, said, words=words)

    def dispatch(
        self, command: Command, source: str, who: Person, said: Spoken | None = None, *, words: str = ""
    ) -> HistoryEntry:
        """Make a command the active one → its history entry; `words`: how it was put, if not by its own words.

        Raises Problem 403 to 503.
        """
        words = words or command.heard_as
        if command.name in self.handlers:
            return self._handle(command, words, source, who, said)
        if command.name == STOP_MOVING.name:
            self.setpoint_sender.stop()
            self._announce_end("cancelled", Statement("stop.stopped_by", name=who.name), who)
        else:
            self.admit(command, words, source, who, said)
        entry = self._history.add("command", who, state="running", **row_of(command, words, source))
        self._hand_to_pilot(entry, command, who)
        if command.name != STOP_MOVING.name:
            self._announce_end(
                "pre-empted",
                Statement("command.pre_empted", words=command.heard_as),
                at=None if said is None else said.ended,
            )
        return entry

    def _handle(self, command: Command, words: str, source: str, who: Person, said: Spoken | None) -> HistoryEntry:
        if spec_of(command.name).moves:
            self.admit(command, words, source, who, said)
        fields = row_of(command, words, source)
        try:
            self.handlers[command.name](command, who)
        except Problem as problem:
            self._history.add("command", who, state="refused", remark=problem.detail, **fields)
            raise
        return self._history.add("command", who, state="done", **fields)

    def admit(self, heard: Command, words: str, source: str, who: Person, said: Spoken | None) -> None:
        """Check that this person may move the robot now; a free lease goes to this person.

        Raises Problem 403 to 503, which is then in the history, too.
        """
        try:
            self._check_motion(who, heard)
            if said is not None:
                self.freshness.check(said, source, who)
            self._obtain(who)
            if self._active.does(heard):
                raise Problem(
                    409, spec_of(heard.name).already or Statement("command.already_doing", words=heard.heard_as)
                )
        except Problem as problem:
            fields = row_of(heard, words, source)
            self._history.add("command", who, state="refused", remark=problem.detail, **fields)
            raise

    def drive(self, message: inbound.JogMessage, who: Person) -> None:
        """A hand on the keys. Raises Problem 403, 409, 503."""
        moving = message.v != 0.0 or message.w != 0.0
        if not self._lease.held_by(who):
            if not moving:
                return
            self._check_motion(who)
            self._obtain(who)
        elif self._robot.status().state == "disarmed":
            # the gate was started again: it has forgotten who drives
            self.setpoint_sender.arm(self._lease.epoch, who.name)
        now = time.monotonic()
        self._lease.active(who, now)
        if moving and (why := self.hand_warning(message)):
            self._warn_hand(message.press, who, why)
            return
        if moving:
            self._press(message.press, who, now)
        self.setpoint_sender.jog(message)

    def _warn_hand(self, press: int, who: Person, why: str) -> None:
        """Stop a hand and the goal that it took over from, and say once for each press why. Raises Problem 409."""
        self.setpoint_sender.stop()
        self._end_goal(who)
        warned, self._warned_press = self._warned_press, press
        if warned != press:
            raise Problem(409, why)

    def admit_waiting(self, who: Person) -> None:
        """Check that this person may move the robot, which will begin later; a free lease goes to this person.

        Raises Problem 403, 409, 503.
        """
        self._check_motion(who)
        self._obtain(who)

    def admit_own_navigation(self, who: Person) -> None:
        """Check that this person may let the robot's own navigation drive; a free lease goes to this person.

        Raises Problem 403, 409, 503.
        """
        self._check_motion(who)
        if self._active or self._jog is not None:
            raise Problem(409, Statement("command.two_cannot_steer"))
        self._obtain(who)

    def abandon(self, press: int) -> None:
        """The socket of a hand that was driving is gone: zero now, instead of waiting for the deadman."""
        if self._jog is not None and self._jog.press == press:
            self.setpoint_sender.stop()
            self._history.end(self._jog.entry, "cancelled", Statement("command.browser_gone"))
            self._jog = None

    def stop(self, who: Person, source: str, press: int = 0) -> None:
        """Everything cancelled, zero speed; anyone signed in. A `press` that comes by two ways is recorded once."""
        self._stop_controller.stop(who, source, press)

    def busy_besides(self, sources: Container[str]) -> bool:
        """Return whether a hand drives, or a goal is under way that came another way than these."""
        return self._jog is not None or self._active.busy_besides(sources)

    def obeys(self, number: int) -> bool:
        """Return whether the command of this row in the history is under way, and no other is to take its place."""
        return self._active.obeys(number)

    def halt(self, who: Person, source: str, press: int = 0) -> None:
        """The same, latched."""
        self._stop_controller.halt(who, source, press)

    def reset(self, who: Person, source: str) -> None:
        """Lift the latch; the lease holder only, and it never moves. Raises Problem 403, 409, 503."""
        self._stop_controller.reset(who, source)

    def change_lease(self, do: LeaseAction, who: Person) -> None:
        """Acquire, renew, take or release the lease, ask for it, give it to who asks or keep it.

        Raises Problem 403, 409; Refused when another holds it.
        """
        if not who.may("operator"):
            raise Problem(403, Statement("lease.only_operators"))
        profile = self._robot.profile
        if not profile.drives and not profile.dry_run:
            raise Problem(409, profile.refusal())
        before, holder = self._lease.epoch, self._lease.holder
        if do in ("give", "keep"):
            self._answer_request(who, give=do == "give")
            return
        if do == "release":
            self._lease.release(who)
        elif do == "ask":
            self._ask_for_control(who)
        elif do == "take":
            self._lease.take(who, time.monotonic())
        elif do == "renew" and not self._lease.held_by(who):
            raise Problem(409, Statement("lease.nothing_to_renew"))
        else:
            self._lease.acquire(who, time.monotonic())
        if self._lease.epoch == before:
            return
        took = do == "take" and holder is not None
        self._changed_hands(
            Statement("lease.took_over", name=who.name) if took else Statement("lease.gave_back", name=who.name)
        )
        self._history.add("lease", who, remark=do)
        if took:
            self._notifications.tell(
                "warning",
                Statement("lease.took_over_from", name=who.name, other=holder.name if holder else "nobody"),
                "lease",
            )

    def _ask_for_control(self, who: Person) -> None:
        asked = self._lease.request
        self._lease.ask(who, time.monotonic())
        if self._lease.request not in (None, asked):
            self._history.add("lease", who, remark="ask")

    def _answer_request(self, who: Person, *, give: bool) -> None:
        asker = self._lease.answer(who, time.monotonic(), give=give)
        if give:
            self._changed_hands(Statement("lease.gave_to", name=who.name, other=asker.name))
        self._history.add("lease", who, remark=f"{'gave' if give else 'did not give'} control to {asker.name}")
        gave = Statement("lease.gave_to", name=who.name, other=asker.name)
        kept = Statement("lease.keeps", name=who.name, other=asker.name)
        self._notifications.tell("info", gave if give else kept, "lease")

    def forget(self, who: Person) -> None:
        """The person signed out."""
        held = self._lease.held_by(who)
        self._lease.forget(who)
        if held:
            self._changed_hands(Statement("lease.signed_out", name=who.name))

    # what happens by itself

    def tick(self, now: float) -> None:
        """Twenty times a second: leases that lapse, presses that end, a gate that stopped by itself."""
        if now - self._ticked > MAX_TICK_GAP_S:  # sound that waited in the sockets looks as if it came just now
            self.freshness.stood_still(now - self._ticked, now + MAX_TICK_GAP_S)
        self._ticked = now
        if self._jog and now - self._jog.seen > LET_GO_PAUSE_S:
            self._history.end(self._jog.entry, "done", "")
            self._jog = None
        lost = self._lease.tick(now, obeying=self._active.keeps_lease(self._lease.holder))
        if lost is not None:
            silence = Statement("lease.gone_silent", name=lost.name, seconds=f"{leases.GRACE_S:g}")
            self._changed_hands(silence + self._active.how_to_renew())
            self._history.add("lease", lost, remark="lapsed")
            self._notifications.tell("info", Statement("lease.gone", name=lost.name), "lease")
        asker = self._lease.tick_request(now)
        if asker is not None and (holder := self._lease.holder) is not None:
            self._notifications.tell(
                "info", Statement("lease.no_answer", name=holder.name, other=asker.name), "lease"
            )
        status = self._robot.status()
        self._stop_controller.tick(status, now)
        self._watch_gate(status, now)

    def ended(self, endings: Sequence[ActiveCommandStatus]) -> None:
        """The pilot reports how active commands ended."""
        for status in endings:
            self.setpoint_sender.revoke(status.id)
            self._active.end(status.id)
            self._history.end(status.id, status.state, status.remark)

    def ended_without_pilot(self, why: str) -> None:
        """No pilot says it now: everything under way has failed, and a pilot that comes to itself hears so."""
        self._announce_end("failed", why)
        for number in self._active:
            self.setpoint_sender.revoke(number)
            self._history.end(number, "failed", why)
        self._active.clear()
        if self.pilot is not None:
            self.pilot.cancel("failed", why)

    def cancel(self, state: Ending, why: str, objector: Person | None = None) -> None:
        """End the active command; it no longer drives from now on. `objector`: the person who did not want it."""
        self._announce_end(state, why, objector)
        self._active.cancel()
        for number in self._active:
            self.setpoint_sender.revoke(number)
        if self.pilot is not None:
            self.pilot.cancel(state, why)

    # steps of the above

    def _announce_end(
        self, state: Ending, why: str, objector: Person | None = None, *, at: float | None = None
    ) -> None:
        self.freshness.void(why, objector=objector, at=at)
        for tell in self.when_cancelled:
            tell(state, why, objector is not None)

    def _hand_to_pilot(self, entry: HistoryEntry, heard: Command, who: Person) -> None:
        if not self._robot.profile.drives and not self._robot.profile.dry_run:
            self._history.end(entry.id, "done", Statement("command.dry_recording"))
            return
        if self.pilot is None or self._robot.link()[0] not in REACHED:
            self._history.end(entry.id, "done", Statement("command.no_report"))
            return
        self._active.begin(entry.id, ActiveCommand(who, entry.source, time.monotonic(), heard))
        if self._robot.profile.drives and spec_of(heard.name).moves:
            self.setpoint_sender.authorize(entry.id, self._lease.epoch)
        try:
            self.pilot.tell(entry.id, heard, entry.source, who.name)
        except Refused as refused:
            self.setpoint_sender.revoke(entry.id)
            self._active.end(entry.id)
            self._history.end(entry.id, "refused", str(refused))
            raise problem_of(refused) from None

    def _watch_gate(self, status: GateStatus, now: float) -> None:
        """A command that the gate stopped, or does not let through, has failed. A dry run asks it for nothing."""
        if not self._robot.profile.drives:
            return
        tripped, self._trips = status.trips > self._trips, status.trips
        self._tripped = now if tripped else self._tripped
        elapsed = self.freshness.time.elapsed  # a simulated robot's clock waits for who is to be heard
        older = [given for given in self._active.given() if elapsed(given, now) > SETTLING_S]
        if not older or not status.refused or status.holds:
            self._obeyed = now
        refuses = elapsed(self._obeyed, now) > SETTLING_S
        if (older and tripped) or (refuses and self._tripped > min(older)):
            self.cancel("failed", status.stopped_because)
        elif refuses:
            self.cancel("failed", status.refused_because)

    def close(self) -> None:
        """The console is ending: the robot stands, and nothing moves it any more."""
        self._closed = True
        self.setpoint_sender.stop()
        self.ended_without_pilot(Statement("command.console_ended"))

    def _check_motion(self, who: Person, heard: Command | None = None) -> None:
        """Check that this person may move the robot now, or give it this command. Raises Problem 403, 409, 503."""
        if self._closed:
            raise Problem(503, Statement("console.ending"))
        if not who.may("operator"):
            raise Problem(403, VIEWERS_WATCH)
        profile = self._robot.profile
        if not profile.drives and (why := profile.refusal(None if heard is None else spec_of(heard.name))):
            raise Problem(409, why)
        if self._robot.link()[0] not in REACHED:
            raise Problem(503, self._robot.trouble or Statement("robot.unreached"))
        if self.pilot is None:
            raise Problem(503, Statement("pilot.not_running"))
        if self._robot.status().state == "halted":
            raise Problem(409, Statement("command.halted"))

    def _obtain(self, who: Person) -> None:
        """The lease, when it is free or already theirs; the gate knows it before any command."""
        before = self._lease.epoch
        try:
            self._lease.acquire(who, time.monotonic())
        except Refused as refused:
            raise problem_of(refused) from None
        if self._lease.epoch != before:
            self._history.add("lease", who, remark="acquire")
        self.setpoint_sender.arm(self._lease.epoch, who.name)

    def _changed_hands(self, why: str) -> None:
        self.cancel("cancelled", why)
        holder = self._lease.holder
        self.setpoint_sender.hand_over(self._lease.epoch, holder.name if holder else None)

    def _end_goal(self, who: Person) -> None:
        """A hand that drives, or would, ends a goal; the goal does not resume."""
        by_hand = Statement("command.by_hand", name=who.name)
        if self._active:
            self.cancel("pre-empted", by_hand)
        else:
            self._announce_end("pre-empted", by_hand)

    def _press(self, press: int, who: Person, now: float) -> None:
        self._end_goal(who)
        if self._jog is not None and self._jog.press == press:
            self._jog.seen = now
            return
        if self._jog is not None:
            self._history.end(self._jog.entry, "done", "")
        self._jog = ActiveJog(who, press, self._history.add("drive", who, state="running").id, now)
