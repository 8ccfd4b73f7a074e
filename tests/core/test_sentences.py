"""Every sentence that an operator commonly sees has a code, and the catalogue has no sentence that nobody says."""

import ast
import json
import pickle
import re
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from console.control.lease import OTHER_DRIVES
from console.http.problems import Problem, problem_of, refused
from console.workers.job import JobFailure
from core.errors import Refused
from core.gate.status import GATE_LATE, GateStatus
from core.sensors.checks import CHECKS, fault
from core.sentences import KEY, PageTexts, Statement, catalogue, code_of, coded, plain

ROOT = Path(__file__).parents[2]
SAID_TO_OPERATORS = (
    "core/commands",
    "core/gate/gate.py",
    "core/gate/status.py",
    "core/navigation",
    "core/pilot/notices.py",
    "core/pilot/pilot.py",
    "core/slam/relocalization/recovery.py",
    "core/speech/understanding/grammar.py",
    "console/connection/service.py",
    "console/control/dispatcher.py",
    "console/control/lease.py",
    "console/control/link_monitor.py",
    "console/control/pending_commands.py",
    "console/control/stop.py",
    "console/speech/browser_microphone.py",
    "console/speech/voice_commands.py",
)
WITHOUT = (
    "An older lease",  # the gate's, for programs that send setpoints themselves
    "One lease has one holder",
    "The setpoint is malformed",
    "Stale: ",
    "Old: its nonce",
    "A speed is not a finite number",
    "It was sent before",
    "The console's heartbeat",
    "Dry run: ",
    "Following the wall",
    "{}",  # put together of others
    "I see nobody.",  # in a dry run
    "I see someone, but not",
    "Stands still and waits",  # summaries of commands
    "Stops moving at once",
    "Turns left",
    "Turns right",
)
HOLE = re.compile(r"\{(\w+)\}")
SOURCES = sorted(
    path for room in ("core", "console") for path in (ROOT / room).rglob("*.py") if path.name != "sentences.py"
)
CODES = {key.removeprefix(KEY): text for key, text in catalogue().items() if key.startswith(KEY)}


def written(node: ast.AST) -> str | None:
    """The text of a string with {} for what is put in; None: no string."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return re.sub(r"\{[^{}]*\}", "{}", node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)
    return None


def strings(path: Path) -> Iterator[str]:
    """All strings of a module but its docstrings and the summaries of commands."""
    tree = ast.parse(path.read_text())
    left_out: set[int] = set()
    for node in ast.walk(tree):
        alone = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        summary = isinstance(node, ast.AnnAssign) and getattr(node.target, "id", "") == "summary"
        if alone or summary or isinstance(node, ast.JoinedStr):
            left_out |= {id(part) for part in ast.walk(node) if part is not node}
    for node in ast.walk(tree):
        if id(node) not in left_out and (text := written(node)) is not None:
            yield text


@pytest.fixture(scope="module")
def literals() -> dict[str, set[str]]:
    """Of each string of the program, where it stands."""
    found: dict[str, set[str]] = {}
    for path in SOURCES:
        for text in strings(path):
            found.setdefault(text, set()).add(path.relative_to(ROOT).as_posix())
    return found


def statements() -> Iterator[tuple[str, ast.Call]]:
    """The calls that make a sentence of a code, and where each is."""
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text())) if "Statement(" in path.read_text() else ():
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Statement":
                yield f"{path.relative_to(ROOT)}:{node.lineno}", node


def test_every_sentence_in_the_program_has_its_words_and_all_of_its_values() -> None:
    wrong: list[str] = []
    for where, call in statements():
        given = {keyword.arg for keyword in call.keywords}
        for code in [one.value for one in ast.walk(call.args[0]) if isinstance(one, ast.Constant)]:
            holes = set(HOLE.findall(CODES.get(str(code), "")))
            if str(code) in CODES and (not given or None in given or given == holes):
                continue
            if not isinstance(call.args[0], ast.JoinedStr):
                wrong.append(f"{where}: {code} takes {sorted(holes)}")
    assert wrong == []


def test_the_catalogue_holds_only_what_the_program_says(literals: dict[str, set[str]]) -> None:
    ends = ("_of", "_everywhere")  # of the codes of sentences that say more, or less
    said = {code for code in CODES if code in literals or any(code.removesuffix(end) in literals for end in ends)}
    values = {code for code, text in CODES.items() if text in literals and code == "words.metres"}
    assert CODES.keys() - said - values - CHECKS.keys() == set()


def test_no_words_of_the_catalogue_stand_a_second_time_in_the_program(literals: dict[str, set[str]]) -> None:
    once = {HOLE.sub("{}", text): code for code, text in CODES.items() if code not in CHECKS and " " in text}
    assert {text: literals[text] for text in once.keys() & literals.keys()} == {}


def test_every_sentence_that_operators_commonly_see_has_a_code() -> None:
    paths = [
        path
        for part in SAID_TO_OPERATORS
        for path in ([ROOT / part] if part.endswith(".py") else sorted((ROOT / part).rglob("*.py")))
    ]
    bare = {
        text
        for path in paths
        for text in strings(path)
        if re.fullmatch(r"[A-Z“{].* .* .*[.…]", text, re.DOTALL) and not text.startswith(WITHOUT)
    }
    assert len(paths) > 25 and bare == set()


def test_a_sentence_keeps_its_code_through_errors_and_copies_and_loses_it_with_its_words() -> None:
    pattern = Statement("lease.took_over_from")
    sentence = pattern(name="Ann", other="{Bob}")
    assert sentence == "Ann took over from {Bob}." and "{name}" in pattern
    for same in (str(sentence), str(Refused(sentence)), pickle.loads(pickle.dumps(sentence))):
        assert code_of(same) == ("lease.took_over_from", {"name": "Ann", "other": "{Bob}"})
    assert coded(plain(sentence), code_of(sentence)) == sentence and type(plain(sentence)) is str
    for cause in (sentence, Refused(sentence)):
        nested = Statement("command.not_begun", why=cause)
        assert nested == f"It had not begun: {sentence}"
        assert [type(text) for text in (nested.said.values or {}).values()] == [str]
    assert code_of(f"So: {sentence}") == code_of(sentence + "") == (None, None)
    with pytest.raises(KeyError):
        pattern(name="Ann")
    with pytest.raises(NotImplementedError):
        plain(object())


def test_a_sentence_keeps_its_code_through_the_gates_packets_and_a_workers_failure() -> None:
    status = GateStatus(state="halted", reason=GATE_LATE, refused=Statement("gate.not_armed"))
    packet = json.loads(json.dumps(status.to_packet()))
    assert packet["reason"] == "the gate was late"
    back = GateStatus.of_packet(packet)
    assert back == status and code_of(back.reason).code == "gate.reason_late"
    assert code_of(back.refused_because) == ("gate.refuses", {"why": "The robot is not armed."})
    failure = JobFailure("Refused", plain(GATE_LATE), said=code_of(GATE_LATE))
    crossed = msgspec.msgpack.decode(msgspec.msgpack.encode(failure), type=JobFailure)
    assert code_of(coded(crossed.sentence, crossed.said)).code == "gate.reason_late"


def test_a_fault_says_its_sentence_with_its_values() -> None:
    found = fault("scan.late", "front", age="0.7")
    assert code_of(found.statement) == ("scan.late", {"sensor": "front", "age": "0.7"})
    assert found.statement == found.sentence == CODES["scan.late"].format(sensor="front", age="0.7")


def test_a_refusal_carries_the_code_and_the_values_of_its_sentence() -> None:
    problem = problem_of(Refused(OTHER_DRIVES(holder="Ann")))
    assert problem.detail == "Ann drives now. Ask for control, or take over."
    body = json.loads(problem.body())
    assert (body["code"], body["values"], body["status"]) == ("lease.other_drives", {"holder": "Ann"}, 409)
    answer = json.loads(msgspec.json.encode(refused(7, problem), enc_hook=plain))
    assert (answer["code"], answer["values"], answer["detail"]) == (body["code"], body["values"], problem.detail)


def test_a_sentence_without_a_code_is_told_as_before() -> None:
    assert set(json.loads(Problem(404, "There is none.").body())) == {"type", "title", "status", "detail"}


def test_a_file_says_a_sentence_in_the_language_of_the_page() -> None:
    """What holds here holds for `inLanguage` of the page: tests/js/texts.test.js."""
    texts = PageTexts("de")
    assert texts.t("report.drive", map="lab") == "Fahrt: lab"
    assert texts.said(Statement("come.only_legs")) == "Ich sehe nur Beine; der Laser behält Sie."
    assert texts.said("Counted as view 4.") == "Gezählt als Ansicht 4."
    assert texts.said("I come. I see only legs; the laser keeps you.").startswith("Ich komme. Ich sehe")
    assert texts.said("Nobody wrote this sentence.") == "Nobody wrote this sentence."
    assert PageTexts().said("Counted as view 4.") == "Counted as view 4."
