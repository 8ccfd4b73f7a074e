"""A part of a recording as a recording of its own: every message as it is, with what held at its beginning."""

from pathlib import Path
from typing import IO, cast

from mcap.reader import McapReader, make_reader
from mcap.records import Channel, Message, Schema

from core.errors import BadInput
from core.files import reason, unfinished
from core.recording.drive import NO_OWN_RECORDING, is_drive
from core.recording.frame_record import ROBOT
from core.recording.mcap_writing import BROKEN_RECORD, NS_PER_S, McapRecording, RecordedFile
from core.recording.ros_writing import LATCHED_TOPICS, RosMessage

MIN_PART_S = 0.1
Found = tuple[Schema | None, Channel, Message]


def write_excerpt(source: Path, target: Path, begin_s: float, end_s: float) -> RecordedFile:
    """The part from `begin_s` to `end_s` [s] after the start of `source` → the file `target`, which does not exist.

    The map, the mountings and the robot's description are those that held at its beginning; attachments and the
    description of the recording go along. Raises BadInput, Unwritable.
    """
    if not is_drive(source):
        raise BadInput(NO_OWN_RECORDING)
    try:
        with source.open("rb") as file:
            return _copied(make_reader(cast(IO[bytes], file)), source, target, begin_s, end_s)
    except OSError as trouble:
        raise BadInput(f"{source.name} cannot be read: {reason(trouble)}") from None
    except BROKEN_RECORD:
        raise BadInput(f"{source.name} is damaged; no part of it can be cut out.") from None


def _copied(reader: McapReader, source: Path, target: Path, begin_s: float, end_s: float) -> RecordedFile:
    summary = reader.get_summary()
    if summary is None or summary.statistics is None:
        raise BadInput(f"{source.name} was not finished; it is recovered at the next start of the console.")
    first, last = summary.statistics.message_start_time, summary.statistics.message_end_time
    begin = first + round(max(begin_s, 0.0) * NS_PER_S)
    end = min(first + round(end_s * NS_PER_S), last)
    if end - begin < MIN_PART_S * NS_PER_S:
        length = (last - first) / NS_PER_S
        raise BadInput(f"A part begins before it ends, and lies between 0 and {length:.1f} s.")
    other = McapRecording(target, unfinished(target))  # of one that is killed nothing is recovered: it is cut again
    try:
        _copy(reader, other, begin, end)
        return other.finish()
    except BaseException:
        other.discard()
        raise


def _copy(reader: McapReader, other: McapRecording, begin: int, end: int) -> None:
    for one in reader.iter_attachments():
        other.attach(one.name, one.media_type, one.data)
    for described in reader.iter_metadata():
        other.describe(described.name, described.metadata)
    for _, found in sorted(_held_at(reader, begin).items()):
        other.add([_again(found)], begin / NS_PER_S)
    for found in reader.iter_messages(start_time=begin, end_time=end + 1):
        other.add([_again(found)], found[2].log_time / NS_PER_S)


def _held_at(reader: McapReader, begin: int) -> dict[str, Found]:
    """The newest message before `begin` [ns] of every topic whose messages hold until the next one."""
    held: dict[str, Found] = {}
    for topic in (*LATCHED_TOPICS, ROBOT):
        newest = next(iter(reader.iter_messages([topic], end_time=begin, reverse=True)), None)
        if newest is not None:
            held[topic] = newest
    return held


def _again(found: Found) -> RosMessage:
    schema, channel, message = found
    return RosMessage(
        channel.topic, "" if schema is None else schema.name, message.publish_time / NS_PER_S, message.data
    )
