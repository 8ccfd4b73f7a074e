"""Words → commands: what moves the robot, what stops it, and that nothing else does either."""

import csv
import json
import re
import time
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from core.commands import VOCABULARY, particulars, spec_of
from core.commands.command import Command
from core.navigation.places import NamedPlace
from core.speech.understanding.grammar import ENDS, OTHER_WORDS, TYPESET, OwnPhrases, Refusal, bounds, say, understand
from core.speech.understanding.place_names import place_phrases
from tests.core.speech.spelling import spell

MOVING = {"turn_left", "turn_right", "continue", "stop_at", "come_here", "follow_me"}


def moves(words: str, *, spoken: bool = False) -> bool:
    heard = understand(words, spoken=spoken)
    return isinstance(heard, Command) and heard.name in MOVING


@st.composite
def orders(draw: st.DrawFn) -> tuple[str, dict[str, float], str]:
    kind = draw(st.sampled_from(VOCABULARY))
    pattern = draw(st.sampled_from(kind.words))
    numbers = {
        number.name: draw(st.integers(round(number.low * 100), round(number.high * 100))) / 100
        for number in kind.numbers
        if number.default is None
    }
    return kind.name, numbers, pattern


@given(orders(), st.sampled_from(["meters", "metres", "m", "meter", "metre"]), st.booleans())
def test_every_command_within_its_bounds_is_understood_as_itself(
    order: tuple[str, dict[str, float], str], unit: str, in_words: bool
) -> None:
    name, numbers, pattern = order
    written = {key: spell(value) for key, value in numbers.items()} if in_words else numbers
    words = pattern.format(**written) if in_words else say(spec_of(name), numbers, pattern)
    heard = understand(words.replace("meters", unit))
    assert isinstance(heard, Command)
    assert heard.name == name
    assert {key: heard.numbers[key] for key in numbers} == numbers
    again = understand(heard.heard_as)
    assert isinstance(again, Command)
    assert (again.name, again.numbers) == (heard.name, heard.numbers)


@given(orders(), st.text(min_size=1, max_size=12), st.booleans())
def test_anything_added_to_a_command_keeps_the_robot_from_moving(
    order: tuple[str, dict[str, float], str], more: str, before: bool
) -> None:
    name, numbers, pattern = order
    words = say(spec_of(name), numbers, pattern)
    spoilt = f"{more} {words}" if before else f"{words} {more}"
    unit_completes_it = " ".join(spoilt.lower().rstrip(ENDS).split()).endswith((" m", "meters", "metres"))
    if more.translate(TYPESET).strip(f"{ENDS}\t\r\n") and not unit_completes_it:
        assert not moves(spoilt)


BEGINNINGS = re.compile("turn|continue|go|stop|follow|come|start", re.IGNORECASE)


@given(st.text(max_size=300).filter(lambda words: not BEGINNINGS.search(words)))
def test_random_text_never_moves_the_robot(words: str) -> None:
    assert not moves(words)


RIGHT_WORDS = "turn|left|right|stop|at|and|continue|meters|1|two|point|go|to|minus|for"


@given(st.lists(st.sampled_from(RIGHT_WORDS.split("|"))))
def test_a_shuffle_of_the_right_words_moves_only_as_a_whole_sentence(words: list[str]) -> None:
    sentence = " ".join(words)
    whole = r"turn left|turn right|continue \S+( \S+)* meters|(stop at|go to) \S+( \S+)* and \S+( \S+)*( meters)?"
    assert not moves(sentence) or re.fullmatch(whole, sentence)


@given(st.text(max_size=60), st.text(max_size=60))
def test_the_word_stop_stops_whatever_stands_around_it(before: str, behind: str) -> None:
    heard = understand(f"{before} stop {behind}")
    assert isinstance(heard, Command)
    assert heard.name in ("stop_moving", "stop_at")


@pytest.mark.parametrize(
    "words",
    [
        "stop",
        "STOP!",
        "stop moving",
        "don't stop",
        "please stop at 1 and 2",
        "stop at 1 and 2 please",
        "stop at 1",
        "stop at",
        "stop at the shop",
        "stop at one and to",
        "stop at 99 and 1",
        "stop at 1 and 2 feet",
        "<b>stop</b>",
        "stop_at",
        "non-stop",
        "ＳＴＯＰ",
        "s\u200btop",
        "\x00stop\x00",
        "\ud800stop",
        "x " * 50_000 + "stop",
    ],
)
def test_whatever_contains_the_word_stop_stops(words: str) -> None:
    heard = understand(words)
    assert isinstance(heard, Command)
    assert heard.name == "stop_moving"


@pytest.mark.parametrize("words", ["stopped", "unstoppable", "bus-stops", "top moving", "start", "sto p"])
def test_a_word_that_merely_resembles_stop_does_not_stop(words: str) -> None:
    heard = understand(words)
    assert isinstance(heard, Refusal) or heard.name == "start"


STOPS = """stop|stopp|stoppp|stops|stopping|stopstop|stop stop|stop it|stooop|S.T.O.P.|s t o p|s-t-o-p
e-stop|estop|STOP!!|please stop|emergency stop|halt|HALT!|halt halt|halt now|please halt|robot, halt|wait
wait!|wait, wait|no wait|wait a second|wait please|freeze|Freeze!|hold|hold on|hold it|hold still|no|No!
no, no, no|nope|no stop|oh no|cancel|cancel that|cancel it|abort|abort that|don't move|don’t move|dont move
do not move|don't go|brake|brakes|break|pause|quit|enough|cease|stay|stay there|stand still|whoa|okay, hold on
hey, wait|robot wait|ｈａｌｔ|“halt”|wait…"""


@pytest.mark.parametrize("words", STOPS.replace("\n", "|").split("|"))
@pytest.mark.parametrize("spoken", [False, True])
def test_a_word_that_means_stop_stops(words: str, spoken: bool) -> None:
    heard = understand(words, spoken=spoken)
    assert isinstance(heard, Command) and heard.name == "stop_moving"


ABOUT_STOPS = """wait for me|wait for the bus|the waiter waits|halt the robot|freeze right there|don't turn left
no left|never turn left|robot, don't continue 2 meters|hold the door|cancel the meeting|stopped|unstoppable
hault|frezze|cancle|wiat|stpo|sotp|shop|that's enough|whoa there|Wait, what?|not now|no problem"""


@pytest.mark.parametrize("words", ABOUT_STOPS.replace("\n", "|").split("|"))
def test_where_stop_may_be_meant_nothing_else_is_offered_and_talk_is_no_stop(words: str) -> None:
    heard = understand(words)
    if words == "unstoppable":
        assert isinstance(heard, Refusal) and heard.suggestions[0] == "stop moving"
    else:
        assert isinstance(heard, Refusal) and heard.suggestions == ("stop",)


def test_the_first_offer_for_unknown_words_is_stop() -> None:
    for words in ("fly", "arrête", "nein", "basta", "", "x" * 200):
        heard = understand(words)
        assert isinstance(heard, Refusal) and heard.suggestions[0] == "stop moving"


@pytest.mark.parametrize(
    ("words", "metres"),
    [
        ("continue half a meter", 0.5),
        ("continue a meter", 1.0),
        ("continue two and a half meters", 2.5),
        ("continue one and a half meter", 1.5),
        ("continue 2 and a half m", 2.5),
        ("continue 1,5 meters", 1.5),
        ("continue 10,25m", 10.25),
        ("continue 50 centimeters", 0.5),
        ("continue fifty centimetres", 0.5),
        ("continue two and a half centimeters", 0.025),
        ("continue 29 centimeters", 0.29),
    ],
)
def test_halves_commas_and_centimeters_are_read_exactly(words: str, metres: float) -> None:
    heard = understand(words)
    assert isinstance(heard, Command) and heard.numbers == {"distance_m": metres}
    again = understand(heard.heard_as)
    assert isinstance(again, Command) and again.numbers == heard.numbers


AMBIGUOUS = """three and a half hundred meters|continue three and a half hundred meters|continue 1,500 meters
continue 1,000 meters|continue minus half a meter|continue -50 centimeters|continue half a meter and a half
continue two and a half and a half meters|continue half two meters|continue a half two meters
continue 1. 5 meters|continue 1, 5 meters|continue two point five, six meters|continue 2. meters
continue 1.5 and a half meters|continue 2 cm|continue a hundred meters|continue −2 meters|continue –2 meters
continue 2 feet|continue 2: meters|continue two half meters|continue 3000 centimeters
continue half a centimeter|continue 99 metres|continue 2 millimeters|go to 30 and 1|go to 3,2|go to 3. and 2
advance 50 meters|go straight for 10 seconds|drive 3 inches|drive 0.5 km|turn left 45 degrees
turn left in 5 meters|go straight and turn left in 5 meters|drive 1-2 m|drive 2 to 3 meters|drive minus 2 m
drive - 2 m|drive 1/2 m|drive 1'500 m|drive ½ m|drive 2½ m|drive 2 m 50 cm|drive 5 or 6 m
drive two more kilometers|go to 3 - 2|continue one five|continue twenty two hundred|I want to drive 2 miles
fly 2 meters|follow me 2 meters"""


@pytest.mark.parametrize("words", AMBIGUOUS.replace("\n", "|").split("|"))
def test_a_number_that_is_not_plainly_one_is_refused_and_no_offer_changes_it(words: str) -> None:
    heard = understand(words)
    assert isinstance(heard, Refusal)
    assert set(heard.suggestions) <= {"stop", "stop moving", "continue 0.02 meters", "stop at 2 and 3"}
    assert "continue 0.02 meters" not in heard.suggestions or words == "continue 2 cm"


NUMBERS_IN_WORDS = st.sampled_from(
    ["2", "3.5", "1,5", "two", "two and a half", "half a", "a", "-1", "minus two", "1/2", "½"]
)
UNITS_IN_WORDS = st.sampled_from(
    ["m", "meters", "cm", "centimeters", "mm", "km", "feet", "inches", "seconds", "percent", ""]
)
TURNS_OF_PHRASE = st.sampled_from(
    [
        "continue",
        "contineu",
        "drive",
        "go forward",
        "move ahead",
        "go straight for",
        "advance",
        "turn left in",
        "go to",
    ]
)
ALL_METRES = {"2": 2, "3.5": 3.5, "1,5": 1.5, "two": 2, "two and a half": 2.5, "half a": 0.5, "a": 1}


@given(
    TURNS_OF_PHRASE,
    NUMBERS_IN_WORDS,
    UNITS_IN_WORDS,
    st.sampled_from(["", " please", " back", " and 3", " more or less"]),
)
def test_what_moves_or_is_offered_has_the_number_of_the_words(
    order: str, number: str, unit: str, behind: str
) -> None:
    assume(number != "a" or unit not in ("", "percent"))  # that is no number
    heard = understand(f"{order} {number} {unit}{behind}")
    offered = [understand(one) for one in heard.suggestions] if isinstance(heard, Refusal) else [heard]
    for one in offered:
        assert isinstance(one, Command)
        if one.name == "continue":
            value = ALL_METRES[number] / (100 if unit.startswith("c") else 1)
            assert one.numbers["distance_m"] == pytest.approx(value, abs=1e-12)
            assert unit in ("m", "meters", "cm", "centimeters", "") and not behind.startswith(
                (" back", " and", " more")
            )


@pytest.mark.real_data
def test_the_phrases_of_strangers_move_only_as_they_mean(shared_data: Path) -> None:
    with (shared_data / "strangers/words/phr.tsv").open() as table:
        rows = list(csv.reader(table, delimiter="\t"))
    assert len(rows) > 200
    for words, meant in rows:
        heard = understand(words)
        if isinstance(heard, Command) and heard.name != "stop_moving":
            shown = f"{heard.name}({heard.numbers['distance_m']:g})" if "distance_m" in heard.numbers else heard.name
            assert shown in meant.split("/"), words
        else:
            assert "reject" in meant.split("/"), words


def test_a_goal_out_of_bounds_stops_and_says_why() -> None:
    heard = understand("stop at 99 and 1")
    assert isinstance(heard, Command)
    assert heard.name == "stop_moving"
    assert heard.remark.startswith("“stop at 99 and 1” was not carried out: ") and "from -20 to 20" in heard.remark


KITCHEN_PHRASES = place_phrases([NamedPlace(name="kitchen", x_m=1.0, y_m=2.0)])


@pytest.mark.parametrize(
    ("words", "own", "ways"),
    [
        ("stop at x and y", (), "“stop at 1 and 0.5”"),
        ("stop at", KITCHEN_PHRASES, "“stop at 1 and 0.5”"),
        ("stop at x and y", KITCHEN_PHRASES, "“stop at 1 and 0.5”, “go to kitchen”"),
        ("Stop at the kichen.", KITCHEN_PHRASES, "“stop at 1 and 0.5”, “stop at the kitchen”"),
    ],
)
def test_stop_at_nowhere_stops_and_says_how_to_name_a_place(words: str, own: OwnPhrases, ways: str) -> None:
    heard = understand(words, own=own)
    assert isinstance(heard, Command) and heard.name == "stop_moving"
    assert heard.remark == f"“{words}” names no known point or place: the robot stopped. Say for example {ways}."


def test_stop_at_once_lacks_nothing() -> None:
    heard = understand("Stop at once!", own=KITCHEN_PHRASES)
    assert isinstance(heard, Command) and heard.name == "stop_moving" and not heard.remark


def test_go_to_is_stop_at() -> None:
    heard = understand("go to minus one point five and 4")
    assert isinstance(heard, Command)
    assert (heard.name, heard.numbers) == ("stop_at", {"x_m": -1.5, "y_m": 4.0})
    assert heard.heard_as == "stop at -1.5 and 4"


def test_the_voice_has_tighter_bounds() -> None:
    assert moves("continue 7 meters")
    assert not moves("continue seven meters", spoken=True)
    assert moves("continue five meters", spoken=True)
    heard = understand("stop at ten and six", spoken=True)
    assert isinstance(heard, Command)
    assert heard.name == "stop_moving"
    refused = understand("continue seven meters", spoken=True)
    assert isinstance(refused, Refusal)
    assert refused.suggestions == ()  # the nearest bound is another distance


@pytest.mark.parametrize(
    ("words", "suggestion"),
    [
        ("trun left", "turn left"),
        ("left turn", "turn left"),
        ("turn lef", "turn left"),
        ("stpo moving", "stop"),
        ("continue 2", "continue 2 meters"),
        ("contineu 2 meters", "continue 2 meters"),
        ("continue 1,5", "continue 1.5 meters"),
        ("continue 50 cm", "continue 0.5 meters"),
        ("go back", "turn left"),
        ("go to", "stop at 1 and 0.5"),
        ("fly", "turn left"),
        ("", "turn left"),
    ],
)
def test_a_near_miss_is_refused_with_what_would_be_understood(words: str, suggestion: str) -> None:
    heard = understand(words)
    assert isinstance(heard, Refusal)
    assert suggestion in heard.suggestions
    assert heard.reason.endswith((".", "?"))


@pytest.mark.parametrize("words", ["stat", "star", "strat", "fly", ""])
def test_start_which_changes_nothing_is_never_suggested(words: str) -> None:
    heard = understand(words)
    assert isinstance(heard, Refusal) and heard.suggestions and "start" not in heard.suggestions


def test_every_suggestion_is_understood() -> None:
    for words in ["fly", "", "x" * 200, "turn", "continue", "continue 9", "go to 1 2", "wiat", *OTHER_WORDS]:
        heard = understand(words)
        assert isinstance(heard, Refusal)
        assert heard.suggestions
        for suggestion in heard.suggestions:
            assert isinstance(understand(suggestion), Command)


@pytest.mark.parametrize("words", ["follow wall", "Follow the wall."])
def test_follow_wall_keeps_half_a_metre_on_the_right(words: str) -> None:
    heard = understand(words)
    assert isinstance(heard, Command)
    assert particulars(heard.name, heard.numbers) == {"distance_m": 0.5, "side": "right"}


def test_the_phrases_of_figure_17_are_all_answered() -> None:
    figure = "start; go to; stop at; start; turn right; go back; stop moving; come; turn left; follow me"
    names = [heard.name if isinstance(heard, Command) else "" for heard in map(understand, figure.split(";"))]
    told = ["start", "", "stop_moving", "start", "turn_right", "", "stop_moving", "come_here"]
    assert names == [*told, "turn_left", "follow_me"]


@pytest.mark.parametrize(
    "words",
    [
        "turn\x00 left",
        "turn\nleft",
        "turn left\nturn right",
        "turn left; turn right",
        "turn\u2003left",
        "turn ｌｅｆｔ",
        "\u202eturn left",
        "\ud800",
        "👈 turn left",
        "<turn left>",
        "continue ٣ meters",
        "continue 3\u200b meters",
        "continue 1e1 meters",
        "continue nan meters",
        "turn left" * 10_000,
        " " * 100_000 + "turn left",
        "one " * 25_000,
        "continue " + "9" * 100_000 + " meters",
        "a" * 100_000,
        "{distance_m}",
        "%s%n",
    ],
)
def test_hostile_text_is_refused_at_once(words: str) -> None:
    began = time.process_time()
    heard = understand(words)
    assert isinstance(heard, Refusal)
    assert time.process_time() - began < 0.2
    assert len(heard.reason) < 300


def test_case_spaces_and_a_full_stop_do_not_matter() -> None:
    assert moves("  TURN   Left. \r\n")
    assert moves("Continue 1.5m!")


@pytest.mark.parametrize(
    ("words", "plain"),
    [
        ("stop at 3, and 2", "stop at 3 and 2"),
        ("Stop at 3, and 2.", "stop at 3 and 2"),
        ("stop at 3 , and 2 .", "stop at 3 and 2"),
        ("Stop at: three, and two!", "stop at 3 and 2"),
        ("stop at, 3 and 2", "stop at 3 and 2"),
        ("stop at 3, and, 2", "stop at 3 and 2"),
        ("stop at 3m, and 2m;", "stop at 3 and 2"),
        ("stop at 3 metres, and 2 metres.", "stop at 3 and 2"),
        ("stop at 1.5, and .5.", "stop at 1.5 and 0.5"),
        ("stop at \u22121 and \u20110.5", "stop at -1 and -0.5"),
        ("go to, minus one, and 2", "stop at -1 and 2"),
        ("continue 1.5 meters.", "continue 1.5 meters"),
        ("continue 2, meters", "continue 2 meters"),
        ("Continue, 2 meters:", "continue 2 meters"),
        ("continue 1.5\u00a0m", "continue 1.5 meters"),
        ("continue\u2009two\u202fmeters", "continue 2 meters"),
        ("Turn, left,", "turn left"),
        ('"turn left"', "turn left"),
        ("“Turn left.”", "turn left"),
        ("‘Turn left’!", "turn left"),
        ("stop!", "stop moving"),
        ("stop, moving.", "stop moving"),
    ],
)
def test_marks_at_the_ends_of_words_and_numbers_do_not_matter(words: str, plain: str) -> None:
    heard, suggested_command = understand(words), understand(plain)
    assert isinstance(heard, Command) and isinstance(suggested_command, Command)
    assert (heard.name, heard.numbers) == (suggested_command.name, suggested_command.numbers)


@pytest.mark.parametrize(
    "words",
    [
        "stop at 3,2",
        "stop at 3, 2",
        "stop at (3, 2)",
        "stop at (3 and 2)",
        "stop at 3;2",
        "stop at 1,5 and 2",
        "stop at 1, 5 and 2",
        "stop at 3. and 2",
        "stop at 3; and 2",
        "stop at 3,, and 2",
        "stop at 3 and minus, 2",
        "stop at two point five, six and 1",
        "stop at \u20131 and 2",
        "stop at 1\u20142",
        "stop, at 3 and 2",
        "stop: at 3 and 2",
        "Stop. At 3 and 2.",
        "Stop! Go to 3 and 2.",
        "Go to 3 and 2. Stop.",
        "stop at 3 and 2?",
        "stop at 3 and 2...",
        "stop at 3 and 2…",
        "“stop” at 3 and 2",
        "stop at '3' and '2'",
        "stop,",
        "“stop”",
        "(stop)",
        "stop?",
        "stop…",
        "—stop—",
        "turn left, stop",
    ],
)
def test_stop_with_marks_that_leave_a_doubt_stops(words: str) -> None:
    heard = understand(words)
    assert isinstance(heard, Command)
    assert heard.name == "stop_moving"


@pytest.mark.parametrize(
    ("words", "suggestion"),
    [
        ("go to 3, 2", "stop at 3 and 2"),
        ("go to (3, 2)", "stop at 3 and 2"),
        ("turn left?", "turn left"),
        ("turn left...", "turn left"),
        ("“turn left…”", "turn left"),
        ("continue 2 meters …", "continue 2 meters"),
        ("turn left; turn right", "turn left"),
        ("turn. left", "turn left"),
        ("turn left, please", "turn left"),
        (", turn left", "turn left"),
        ("“turn left", "turn left"),
        ("(turn left)", "turn left"),
        ("'turn left' or 'turn right'", "turn left"),
    ],
)
def test_marks_that_leave_a_doubt_move_nothing(words: str, suggestion: str) -> None:
    heard = understand(words)
    assert isinstance(heard, Refusal)
    assert suggestion in heard.suggestions


@given(orders(), st.booleans(), st.lists(st.sampled_from(["", ",", ":", " ,", " :"]), min_size=8, max_size=8))
def test_a_pause_at_the_end_of_a_word_never_changes_a_command(
    order: tuple[str, dict[str, float], str], in_words: bool, pauses: list[str]
) -> None:
    name, numbers, pattern = order
    written = {key: spell(value) if in_words else str(value) for key, value in numbers.items()}
    words = pattern.split()
    marked = " ".join(
        word + ("" if word == "stop" else pause) for word, pause in zip(words, pauses, strict=False)
    ).format(**written)
    marked = re.sub(" ?:(?= m)", "", marked)  # "2: meters" may be a time
    heard, plain = understand(marked), understand(pattern.format(**written))
    assert isinstance(heard, Command) and isinstance(plain, Command)
    assert (heard.numbers, heard.heard_as) == (plain.numbers, plain.heard_as)
    assert heard.name == name


MARKS = [
    ",",
    ".",
    ";",
    ":",
    "!",
    "?",
    "...",
    "…",
    "'",
    '"',
    "“",
    "”",
    "(",
    ")",
    "-",
    "−",
    "–",
    "—",
    "\u00a0",
    "\u2009",
]


@given(
    st.one_of(
        orders().map(lambda order: say(spec_of(order[0]), order[1], order[2])),
        st.lists(st.sampled_from(RIGHT_WORDS.split("|")), min_size=1, max_size=6).map(" ".join),
    ),
    st.lists(st.tuples(st.integers(0, 8), st.booleans(), st.sampled_from(MARKS)), min_size=1, max_size=3),
)
def test_no_mark_ever_makes_another_motion(words: str, marks: list[tuple[int, bool, str]]) -> None:
    """Around words, marks let a motion be as it is, stop it or refuse it; none makes one, and STOP stays in force."""
    marked = words.split(" ")
    for at, before, mark in marks:
        place = at % len(marked)
        marked[place] = mark + marked[place] if before and mark not in "-−" else marked[place] + mark
    heard, plain = understand(" ".join(marked)), understand(words)
    if isinstance(heard, Command) and heard.name in MOVING:
        assert isinstance(plain, Command)
        assert (heard.name, heard.numbers) == (plain.name, plain.numbers)
    if "stop" in words.split(" "):
        assert isinstance(heard, Command)


def test_bounds_are_those_of_the_table() -> None:
    number = spec_of("stop_at").numbers[0]
    assert bounds(number, spoken=False) == (-20, 20)
    assert bounds(number, spoken=True) == (-5, 5)


def test_examples_are_understood_as_their_own_command() -> None:
    for kind in VOCABULARY:
        heard = understand(kind.example)
        assert isinstance(heard, Command)
        assert heard.name == kind.name


PROSE = """The audio signals come from an array of microphones. He turned left at the corner and then he stopped.
Continue reading the book; let us continue the meeting tomorrow. Go somewhere and do something. The left hand side is
right. We had to stop and wait. Turn the light on the left. I left my keys at one and three. Two metres further on."""


def test_prose_never_moves_the_robot_however_it_is_cut() -> None:
    words = PROSE.split()
    for length in range(1, 9):
        for at in range(len(words)):
            cut = words[at : at + length]
            assert not moves(" ".join(cut)) or cut == ["come"]


@pytest.mark.real_data
def test_the_recorded_phrases_are_read_as_written_down(shared_data: Path) -> None:
    """The transcripts of the recordings: commands come out with their numbers, near misses do not move."""
    with (shared_data / "speech_commands_tts/index.tsv").open() as table:
        rows = list(csv.DictReader(table, delimiter="\t"))
    assert len(rows) > 50
    for row in rows:
        heard = understand(row["text"])
        if row["kind"] != "command":
            assert not moves(row["text"])
        elif isinstance(heard, Command):
            name, *numbers = json.loads(row["expected"])
            assert heard.name == name.lower()
            assert [heard.numbers[n.name] for n in spec_of(heard.name).numbers if n.default is None] == numbers
        else:
            assert "not built yet" in heard.reason


@pytest.mark.real_data
def test_what_people_really_said_never_moves_the_robot(shared_data: Path) -> None:
    with (shared_data / "speech_real/index.tsv").open() as table:
        transcripts = [row["transcript"] or "" for row in csv.DictReader(table, delimiter="\t")]
    assert any(transcripts)
    assert not any(moves(words) for words in transcripts)


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("drive forward 1 metre", "continue 1 meters"),
        ("go 2.5 meters straight ahead", "continue 2.5 meters"),
        ("drive 3 m", "continue 3 meters"),
        ("forward", "continue 1.5 meters"),
        ("go forward two and a half", "continue 2.5 meters"),
        ("drive 2 cm", "continue 0.02 meters"),
        ("go 1 meter", "continue 1 meters"),
        ("move 2 m", "continue 2 meters"),
        ("go one metre", "continue 1 meters"),
    ],
)
def test_who_says_forward_is_offered_continue(words: str, offered: str) -> None:
    refusal = understand(words)
    assert isinstance(refusal, Refusal) and refusal.suggestions == (offered,)
