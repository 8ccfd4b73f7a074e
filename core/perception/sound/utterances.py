"""Utterances of a whole recording and their directions."""

from core.message import message
from core.perception.sound.direction import Direction
from core.perception.sound.locate import DEFAULT
from core.perception.sound.multi_source import talkers
from core.perception.sound.settings import DirectionFindingSettings
from core.perception.sound.spectra import noise_of, over_noise, quiet_frames, spectra
from core.perception.sound.voice_activity import VoiceActivityDetector, active_share
from core.sensors.microphones import MicrophoneArray, Sound

BLOCK_S = 60.0  # of sound that are looked through together
LEAD_S = 0.5  # before an utterance that show the noise
MIN_LEAD_S = 0.3  # before the first word: with less, the quietest moments of all are taken for noise
TAIL_S = 0.1
MIN_UTTERANCE_S = 0.1  # that can be looked at
MOST_TALKERS = 3


@message
class SpeechSpan:
    """An interval of speech."""

    begin: float  # [s]
    end: float  # [s]


def utterances(
    sound: Sound, array: MicrophoneArray, settings: DirectionFindingSettings = DEFAULT
) -> tuple[SpeechSpan, ...]:
    """Find the intervals of speech. Raises BadInput when the sound does not fit the array."""
    array.heard(sound)
    found: list[SpeechSpan] = []
    begin, end = sound.stamp, sound.stamp + sound.duration
    while end - begin > MIN_UTTERANCE_S:
        part = sound.part(begin, end if end - begin < 1.5 * BLOCK_S else begin + BLOCK_S)
        found += _within(part, array, settings)
        begin = part.stamp + part.duration
    return tuple(found)


def directions(
    sound: Sound, array: MicrophoneArray, settings: DirectionFindingSettings = DEFAULT
) -> tuple[Direction, ...]:
    """Directions of every utterance in the order of time; of several talkers at once the strongest first.

    Where no beginning of an utterance is found (a person speaks all the time) the sound is looked at as a whole.
    Raises BadInput when the sound does not fit the array.
    """
    found: list[Direction] = []
    for span in utterances(sound, array, settings):
        begin = span.begin
        while span.end - begin > MIN_UTTERANCE_S:
            stop = min(span.end, begin + settings.longest)
            part = sound.part(begin - LEAD_S, stop + TAIL_S)
            first = begin == span.begin and begin - part.stamp >= MIN_LEAD_S
            found += _seen(part, array, begin if first else None, settings)
            begin = stop
    if not found and sound.duration > MIN_UTTERANCE_S:
        found += _seen(sound.part(sound.stamp, sound.stamp + BLOCK_S), array, None, settings)
    return tuple(sorted(found, key=lambda one: one.stamp))


def _seen(
    part: Sound, array: MicrophoneArray, speech_from: float | None, settings: DirectionFindingSettings
) -> tuple[Direction, ...]:
    return talkers(part, array, most=MOST_TALKERS, speech_from=speech_from, settings=settings)


def _within(part: Sound, array: MicrophoneArray, settings: DirectionFindingSettings) -> list[SpeechSpan]:
    seen = spectra(array.heard(part), part.rate, settings)
    power = over_noise(seen, noise_of(seen, quiet_frames(seen, settings), settings))
    activity, spans = VoiceActivityDetector(settings), list[SpeechSpan]()
    begin: float | None = None
    for time, share in zip(seen.times, active_share(power, settings), strict=True):
        change = activity.step(float(share), float(time))
        if change == "begins":
            begin = activity.begin
        elif change == "ends" and begin is not None:
            spans.append(SpeechSpan(begin=part.stamp + begin, end=part.stamp + activity.last_active))
    if activity.begin is not None:
        spans.append(SpeechSpan(begin=part.stamp + activity.begin, end=part.stamp + activity.last_active))
    return spans
