"""The preview of a command: what it would do as the robot stands now."""

from core.commands import spec_of
from core.commands.command import Command, CommandPreview
from core.navigation.person_following import PersonFollowingSettings
from core.perception.people.voice_bearing import VoiceBearing
from core.snapshot import Snapshot

TURN_RADII = 2.2  # radii of the robot from its middle at which a turn is drawn


def preview(command: Command, snapshot: Snapshot, radius: float) -> CommandPreview:
    """Return what the command would do; `radius` [m] of the robot."""
    return spec_of(command.name).preview(command.numbers, snapshot.estimate.pose, TURN_RADII * radius)


def caller(command: Command, snapshot: Snapshot) -> VoiceBearing | None:
    """Return the person to whom it goes: who spoke, or the voice heard last; None for other commands."""
    if spec_of(command.name).target != "person":
        return None
    voices = snapshot.hearing.voices if snapshot.hearing is not None else ()
    fresh = [voice.call for voice in voices if voice.age <= PersonFollowingSettings().fresh]
    return command.call or next(iter(fresh), None)
