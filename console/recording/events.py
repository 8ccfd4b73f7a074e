"""The events of a drive, as they stand in its recording: commands, notices, contacts, the gate, and words."""

from collections.abc import Iterable, Mapping

from core.gate.status import GateStatus
from core.sentences import Statement
from core.snapshot import Notice, Snapshot

EVENTS, STATE, WORDS = "/beckon/events", "/beckon/state", "/speech/text"  # topics
STATE_PERIOD_S = 0.5  # [s] between two states
LOST_PLACE = "place"  # cause of the notices about a pose that is not known


class DriveEvents:
    """Compares each snapshot with the one before."""

    def __init__(self, gate: GateStatus) -> None:
        self._texts: list[tuple[str, str | Mapping[str, object]]] = []
        self._gate, self._contact = gate, False
        self._command = self._notice = -1
        self._state_at = -1e9  # [s]

    def taken(self) -> tuple[tuple[str, str | Mapping[str, object]], ...]:
        """Events since this was last asked: topic, and words or an object."""
        texts, self._texts = tuple(self._texts), []
        return texts

    def heard(self, words: str, verdict: str, command: str | None) -> None:
        self._texts.append((WORDS, words))
        self._add("words", words=words, verdict=verdict, command=command)

    def note(self, words: str, remark: str) -> None:
        self._add("route", words=words, remark=remark)

    def take(self, snapshot: Snapshot, notices: Iterable[Notice], gate: GateStatus) -> str:
        """The newest snapshot → why it should be kept, where something went wrong; else ""."""
        self._take_commands(snapshot)
        self._take_state(snapshot, gate)
        return self._take_contact(snapshot) or self._take_gate(gate) or self._take_notices(notices)

    def _add(self, event: str, **values: object) -> None:
        self._texts.append((EVENTS, {"event": event, **values}))

    def _take_commands(self, snapshot: Snapshot) -> None:
        command = snapshot.active_command
        if command is not None and command.id != self._command:
            self._command = command.id
            facts = {"name": command.name, "numbers": command.numbers, "words": command.heard_as}
            self._add("command", id=command.id, who=command.who, source=command.source, **facts)
        for one in snapshot.endings:
            self._add("command_end", id=one.id, name=one.name, state=one.state, remark=one.remark)

    def _take_contact(self, snapshot: Snapshot) -> str:
        before, self._contact = self._contact, snapshot.contact
        if not snapshot.contact or before:
            return ""
        self._add("contact")
        return Statement("recording.contact")

    def _take_gate(self, gate: GateStatus) -> str:
        before, self._gate = self._gate, gate
        if gate.state != before.state:
            self._add("gate", state=gate.state, reason=gate.reason)
        if gate.trips > before.trips:
            self._add("trip", reason=gate.reason)
            return gate.stopped_because
        return Statement("recording.halted") if gate.state == "halted" != before.state else ""

    def _take_notices(self, notices: Iterable[Notice]) -> str:
        why = ""
        for notice in notices:
            if notice.id > self._notice:
                self._notice = notice.id
                self._add("notice", level=notice.level, text=notice.text)
                if notice.cause == LOST_PLACE and notice.level != "info":
                    why = notice.text
        return why

    def _take_state(self, snapshot: Snapshot, gate: GateStatus) -> None:
        if 0 <= snapshot.stamp - self._state_at < STATE_PERIOD_S:
            return
        self._state_at, pose, command = snapshot.stamp, snapshot.estimate.pose, snapshot.active_command
        state = {
            "stamp_s": snapshot.stamp,
            "pose": [pose.x, pose.y, pose.heading],
            "velocity": [snapshot.velocity.v, snapshot.velocity.w],
            "gate": gate.state,
            "command": None if command is None else command.name,
            "battery": snapshot.battery,
        }
        self._texts.append((STATE, state))
