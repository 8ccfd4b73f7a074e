"""What the console says in English alone, the page says in its language.

`static/i18n/<language>.console.json` has what is commonly seen, `<language>.errors.json` what is seldom.
"""

import ast
import errno
import os
import re
from functools import cache

from console.control.settings_in_use import common
from console.experiments.runs import entry
from console.people.enrollment import ENOUGH, GESTURES, STEP_OUT
from core.commands import VOCABULARY
from core.experiments import EXPERIMENTS
from core.sentences import HOLE, PageTexts, catalogue
from core.settings import section_kinds
from core.speech.quality.osqe import compare
from core.speech.quality.report import REPORT, in_language, page
from tests.console.page_sentences import ROOT, plain, read, sentences, translated

RARE = read("de.errors")
GERMAN = {**read("de.console"), **RARE}
PUT_TOGETHER = re.compile(
    r"fill the |A corner is too close to the |the corner in row|it only points |.*'s field|.*, worst average"
)
SYSTEM = re.compile(  # rows for what Python's libraries say of files, networks and forms
    "|".join(
        [
            *(re.escape(os.strerror(code)) for code in errno.errorcode),
            "timed out|Name or service not known|Temporary failure in name .*|No address associated .*",
            ".*[Ee]xpected `.*|.*[Oo]bject (missing required|contains unknown) field .*|invalid enum value .*",
            ".*, the top of the file|mismatched tag|not well-formed .*|no element found|syntax error",
            "undefined entity|junk after .*|.*line {line},? column {column}.*|.* \\(at end of document\\)",
            "Expecting .*|Extra data|Invalid .*",
            "Unterminated string.*|Unclosed array|Cannot (overwrite|declare) .*|Expected .*|Illegal .*",
        ]
    )
)
UNTRANSLATED = {
    r"console\.api: .*": "stands in the description of the interface",
    r"core\.sentences: .*|.* SELECT .*": "is no sentence",
    r"\S+ (audio|camera)://.*": "holds names alone",
    r"\S+ (MIT|Apache-2\.0): .*": "names a licence and its holder",
    r".*(Here I am, here\.|Continue 1\..*)": "is spoken, or given to a recognizer, in the language of commands",
    r"core\.experiments\.speech_quality: Hand-marked.*": "stands in the text of a result, which is the chapter's",
    r"console\.api\.microphones: (accept|undo) microphones": "is a command of the history",
    r"core\.calibration\..*(Hold the board|tilt the|A corner is too close).*": "has a row for every part, or side",
    r"core\.commands\.dry_run: (Dry run: ;|Dry run: and|but see) .*": "cannot be: no voice",
    r"core\.files: .*": "follows what the system says, and has its row with that",
    r"core\.robots: .*": "is one of two sentences, or goes on with another",
    r"core\.robots\.(live|robot_file): .*": "is the end of a sentence that has its row",
    r"core\.settings: \{complaint\}.*": "has a row for each complaint",
    r"core\.speech\.quality\.report: Below zero.*": "stands in the report alone",
}


def said(sentence: str) -> bool:
    """Whether the page has it, word by word or with what stands in it."""
    return sentence in GERMAN or PageTexts("de").said(sentence) != sentence


@cache
def heard() -> dict[str, str]:
    return sentences()


def test_every_sentence_that_a_page_may_show_has_its_german() -> None:
    known, found = translated(), heard()
    assert len(found) > 1000
    missing = [f"{place.rpartition(':')[0]}: {text}" for text, place in found.items() if plain(text) not in known]
    assert [one for one in missing if not any(re.fullmatch(rule, one, re.DOTALL) for rule in UNTRANSLATED)] == []
    assert {rule for rule in UNTRANSLATED if not any(re.fullmatch(rule, one, re.DOTALL) for one in missing)} == set()


def test_every_row_keeps_what_stands_in_its_sentence_and_is_the_one_that_is_found_for_it() -> None:
    texts, wrong = PageTexts("de"), list[str]()
    for english, german in GERMAN.items():
        values = {name: f"Q{number}" for number, name in enumerate(HOLE.findall(english))}
        assert set(HOLE.findall(german)) <= values.keys(), english
        filled = [HOLE.sub(lambda hole, by=values: by[hole[1]], words) for words in (english, german)]
        if texts.said(filled[0]) != filled[1]:
            wrong.append(english)
    assert wrong == []
    assert [*RARE] == sorted(RARE)


def test_a_hole_does_not_reach_over_the_end_of_a_sentence() -> None:
    """It would hide the German of the sentence before."""
    texts = PageTexts("de")
    assert texts.said("Solve it first. x.toml is empty.") == "Lösen Sie erst. x.toml ist leer."
    assert texts.said("The note could not be saved: No space left on device. The disk may be failing; check it.") == (
        "Die Notiz ließ sich nicht sichern: kein Platz mehr auf dem Datenträger. "
        "Der Datenträger geht vielleicht kaputt; prüfen Sie ihn."
    )
    carried = texts.said("“stop at 9 and 1” was not carried out: “stop at x and y” takes x from -20 to 20 metres.")
    assert carried.startswith("„stop at 9 and 1“ wurde nicht ausgeführt: „stop at x and y“ nimmt")
    assert texts.said("It had not begun: x.toml is empty.") == "Er hatte nicht begonnen: x.toml ist leer."
    assert texts.said("cut.png: The file is cut off.") == "cut.png: Die Datei ist abgeschnitten."
    reasons = "2 × it is damaged (first at byte 8); 1 × it is too long"
    assert texts.said(f"What could not be read: {reasons}.") == (
        "Nicht zu lesen war: 2 × sie ist beschädigt (zuerst bei Byte 8); 1 × es ist zu lang."
    )


def test_every_setting_of_the_page_has_a_name_and_a_translation() -> None:
    offered = [(section, one) for section in section_kinds() for one in common(section)]
    assert len(offered) > 30
    names = {f"setting.{section}.{one.name}" for section, one in offered}
    values = {f"setting.{section}.{one.name}.{value}" for section, one in offered for value in one.choices}
    texts = {key for key in catalogue() if key.startswith("setting.")}
    assert names <= texts <= names | values
    own_names = r".*\.(voice\.voice\..*|whisper|sphinx|respeaker-\w+)"  # of voices, programs and arrays
    assert {value for value in values - texts if not re.fullmatch(own_names, value)} == set()
    texts = {text for _, one in offered for text in (one.meta.meaning, one.watch)}
    assert {text for text in texts if not said(text)} == set()


def test_the_contents_of_help_have_a_translation() -> None:
    titles = re.findall(r"^## (.+)$|\[([^]]+)\]\(", (ROOT / "static/docs/index.md").read_text(), re.MULTILINE)
    assert len(titles) > 50
    assert {one or other for one, other in titles if not said(one or other)} == {"REST"}


def test_every_experiment_every_command_and_the_advice_to_people_have_a_translation() -> None:
    entries = [entry(name) for name in EXPERIMENTS]
    texts = {text for one in entries for text in (one.title, one.reproduces, one.counts) if text}
    texts |= {command.summary for command in VOCABULARY} | {
        STEP_OUT,
        ENOUGH,
        *(gesture.words for gesture in GESTURES),
    }
    assert len(texts) > 30
    assert {text for text in texts if not said(text)} == set()


def test_a_translation_whose_english_is_gone_does_not_stay() -> None:
    files = [path for room in ("core", "console") for path in (ROOT / room).rglob("*.py")]
    articles = [path.read_text() for path in (ROOT / "static/docs").rglob("*.md")]
    there = " ".join("\n".join(articles).split()) + "\n".join(
        " ".join(node.value.split())
        for path in files
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    )
    kept = {text.removeprefix(REPORT) for text in GERMAN if "{" not in text}
    assert len(kept) > 100
    kept = {text for text in kept if not (PUT_TOGETHER.match(text) or SYSTEM.fullmatch(text))}
    patterns = {plain(text) for text in heard()}
    assert [text for text in kept - patterns if text not in there] == []
    rows = [text for text in RARE if "{" in text and plain(text) not in patterns]
    rows = [text for text in rows if not (PUT_TOGETHER.match(text) or SYSTEM.fullmatch(text))]
    pieces = {text: [one.strip(" :.") for one in HOLE.split(text.removeprefix(REPORT))[::2]] for text in rows}
    assert [text for text in rows if any(piece not in there for piece in pieces[text])] == []


def test_the_report_of_speech_quality_is_in_the_page_s_language_but_for_what_was_said() -> None:
    spoken = "start; come here; turn left; stop moving"
    document = page(compare(spoken, spoken, "start; come; turn left; person"), None, {"voice": "en-us"})
    german = in_language(document, PageTexts("de"))
    assert '<html lang="de">' in german and "<style>" in german
    shown = {words.strip() for words in re.findall(r"(?<=>)[^<>]+(?=<)", german.partition("</style>")[2])}
    assert {"Sprachqualität", "Wortfehlerrate", "Umgebung", "Stimme", "come here", "en-us"} <= shown
    english = {words for words in shown if re.fullmatch(r"[A-Za-z' ]{4,}", words) and words in document}
    assert english <= {*spoken.split("; "), *re.findall(r"[a-z]+", spoken), "person", "OSQE"}


def test_every_word_of_a_report_is_used() -> None:
    source = (ROOT / "console/api/reports.py").read_text()
    names = {key.removeprefix("report.") for key in catalogue() if key.startswith("report.")}
    put_together = {"calibration_camera", "calibration_laser"}
    assert len(names) > 20
    assert {name for name in names if not re.search(rf"\b{name}\b", source)} == put_together
