"""Figures of the documentation: each stands between marks that name a stored result and its keys.

`<!--=NAME {key[row][key]:.3f} m-->0.085 m<!--/-->` in a page is written from `static/docs/results/NAME.json`, which
`beckon experiment all NAME` stores. A mark over several lines is a table: `NAME key.key` or `NAME key[1:4]` says what
has its rows, then come its head and the template of a row, in which `{name}` is a row's key.
"""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from core.sentences import static_folder

MARK = re.compile(r"(<!--=([\w-]+) (.*?)-->)(.*?)(<!--/-->)", re.S)
SLICED = re.compile(r"([\w.-]+)(?:\[(\d+):(\d+)\])?")
RESULTS = static_folder() / "docs" / "results"


def results() -> dict[str, dict[str, Any]]:
    """Every stored result by the name of its experiment."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(RESULTS.glob("*.json"))}


def filled(page: str, stored: Mapping[str, Mapping[str, Any]]) -> str:
    """A page whose figures are those of the stored results. Raises LookupError for a key that a result has not."""

    def written(mark: re.Match[str]) -> str:
        begin, name, template, _, end = mark.groups()
        text = _table(stored[name], template) if "\n" in template else _spaced(template.format_map(stored[name]))
        return begin + text + end

    return MARK.sub(written, page)


def _table(result: Mapping[str, Any], template: str) -> str:
    """A line of the table for every row."""
    where, *head, row = template.strip().splitlines()
    asked = SLICED.fullmatch(where)
    if asked is None:
        raise LookupError(where)
    path, begin, end = asked.groups()
    rows: Any = result
    for key in path.split("."):
        rows = rows[key]
    if hasattr(rows, "items"):
        rows = [{"name": name, **rows[name]} for name in rows]
    chosen = rows[int(begin) : int(end)] if begin else rows
    return "\n".join(("", *head, *(_spaced(row.format_map(one)) for one in chosen), ""))


def _spaced(text: str) -> str:
    return re.sub(r"(?<=\d)%", " %", text)


def filled_pages() -> dict[Path, str]:
    """Every page of the documentation that has marks, with the figures of the stored results."""
    stored = results()
    pages = {path: path.read_text(encoding="utf-8") for path in sorted((static_folder() / "docs").rglob("*.md"))}
    return {path: filled(text, stored) for path, text in pages.items() if MARK.search(text)}
