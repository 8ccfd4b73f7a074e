"""The YAML that calibration files are written in: nested mappings, lists, numbers, text. Nothing else is read.

Anchors, aliases and merge keys are refused, so no file can unfold into more than it shows; tags are skipped.
"""

from __future__ import annotations

import re
from typing import Any

from core.errors import BadInput

DEEPEST = 12
NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?")
SPECIAL = {".nan": float("nan"), ".inf": float("inf"), "+.inf": float("inf"), "-.inf": float("-inf")}
WORDS = {"true": True, "false": False, "null": None, "~": None, "": None}
TOKEN = re.compile(r'\s*("(?:[^"\\]|\\.)*"|\'(?:[^\']|\'\')*\'|[\[\]{},]|[^\[\]{},"\']+)')


def read_yaml(text: str) -> dict[str, Any]:
    """Text → its top mapping. Raises BadInput with a sentence for anything that is not plain YAML."""
    lines = _joined(text)
    if not lines:
        raise BadInput("The YAML file is empty.")
    value, rest = _block(lines, 0, lines[0][0], 0)
    if rest != len(lines) or not isinstance(value, dict):
        raise BadInput("The YAML file is not one mapping of names to values.")
    return value


def _joined(text: str) -> list[tuple[int, str]]:
    """Text → (indent, content) of every meaningful line; lists that span lines become one line."""
    lines: list[tuple[int, str]] = []
    open_brackets = 0
    for raw in text.lstrip("﻿").splitlines():
        bare = _without_comment(raw).rstrip()
        if not bare.strip() or (not open_brackets and (bare.startswith("%") or bare in ("---", "..."))):
            continue
        if bare.startswith("--- "):
            bare = bare[4:]
        if "\t" in bare[: len(bare) - len(bare.lstrip())]:
            raise BadInput("The YAML file is indented with tabs; use spaces.")
        if open_brackets:
            indent, content = lines.pop()
            lines.append((indent, f"{content} {bare.strip()}"))
        else:
            lines.append((len(bare) - len(bare.lstrip()), bare.strip()))
        outside = re.sub(r"\"[^\"]*\"|'[^']*'", "", bare)
        open_brackets += sum(outside.count(c) for c in "[{") - sum(outside.count(c) for c in "]}")
    if open_brackets > 0:
        raise BadInput("A list in the YAML file does not end; is the file cut off?")
    return lines


def _without_comment(line: str) -> str:
    found = re.search(r"(^|\s)#", re.sub(r"\"[^\"]*\"|'[^']*'", lambda quoted: "x" * len(quoted[0]), line))
    return line[: found.start()] if found else line


def _block(lines: list[tuple[int, str]], at: int, indent: int, depth: int) -> tuple[Any, int]:
    """The mapping or list that starts at line `at` with this indent → its value and the line after it."""
    if depth > DEEPEST:
        raise BadInput("The YAML file is nested too deeply.")
    if lines[at][1] == "-" or lines[at][1].startswith("- "):
        return _list(lines, at, indent, depth)
    mapping: dict[str, Any] = {}
    while at < len(lines) and lines[at][0] == indent:
        found = re.match(r"(\"[^\"]*\"|'[^']*'|[^\[\]{},\"'&*!|>%@`#][^:]*?)\s*:(?:\s+(.*))?$", lines[at][1])
        if found is None or lines[at][1].startswith("<<"):
            raise BadInput("A line of the YAML file is no name with a value.")
        name, text = found[1].strip("\"'"), _without_tag(found[2] or "")
        if name in mapping:
            raise BadInput("The YAML file says the same name twice.")
        mapping[name], at = _value(lines, at, indent, text, depth)
    return mapping, at


def _value(lines: list[tuple[int, str]], at: int, indent: int, text: str, depth: int) -> tuple[Any, int]:
    """The value after a name: on the same line, or the block on the following lines."""
    if text:
        return _inline(text), at + 1
    following = lines[at + 1] if at + 1 < len(lines) else (-1, "")
    is_list = following[1] == "-" or following[1].startswith("- ")
    if following[0] > indent or (following[0] == indent and is_list):
        return _block(lines, at + 1, following[0], depth + 1)
    return None, at + 1


def _list(lines: list[tuple[int, str]], at: int, indent: int, depth: int) -> tuple[list[Any], int]:
    values: list[Any] = []
    while at < len(lines) and lines[at][0] == indent and lines[at][1].startswith("-"):
        text = lines[at][1][1:]
        inner = text.strip()
        if inner and not inner.startswith(("[", "{", '"', "'")) and re.search(r":(\s|$)|^-\s", inner):
            lines[at] = (indent + 1 + len(text) - len(text.lstrip()), inner)
            value, at = _block(lines, at, lines[at][0], depth + 1)
        else:
            value, at = _value(lines, at, indent, _without_tag(inner), depth)
        values.append(value)
    return values, at


def _without_tag(text: str) -> str:
    if text.startswith(("&", "*")):
        raise BadInput("The YAML file uses anchors or aliases; calibration files do not, so it is not read.")
    return _without_tag(re.sub(r"^!\S*\s*", "", text)) if text.startswith("!") else text


def _inline(text: str) -> Any:
    """A value on one line: a list, a mapping, a number, a text."""
    if text[0] in "|>":
        raise BadInput("The YAML file holds a block of text; calibration files do not.")
    if text[0] not in "[{":
        return _scalar(text)
    tokens = TOKEN.findall(text)
    value, rest = _flow([token.strip() for token in tokens if token.strip()], 0, 0)
    if rest != len([token for token in tokens if token.strip()]):
        raise BadInput("Something follows the end of a list in the YAML file.")
    return value


def _flow(tokens: list[str], at: int, depth: int) -> tuple[Any, int]:
    if depth > DEEPEST:
        raise BadInput("The YAML file is nested too deeply.")
    closing = "]" if tokens[at] == "[" else "}"
    values: list[Any] = []
    names: list[str] = []
    at += 1
    while at < len(tokens) and tokens[at] != closing:
        token = tokens[at]
        if token == ",":
            at += 1
            continue
        if closing == "}":
            name, _, token = token.partition(":")
            names.append(name.strip("\"' "))
            if not token.strip():
                at += 1
                token = tokens[at] if at < len(tokens) else "}"
        if token in ("[", "{"):
            value, at = _flow(tokens, at, depth + 1)
        else:
            value, at = _scalar(_without_tag(token.strip())), at + 1
        values.append(value)
    if at >= len(tokens):
        raise BadInput("A list in the YAML file does not end.")
    return (values if closing == "]" else dict(zip(names, values, strict=True))), at + 1


def _scalar(text: str) -> Any:
    if len(text) >= 2 and text[0] in "\"'" and text[-1] == text[0]:
        return text[1:-1]
    if text.startswith(("&", "*")):
        raise BadInput("The YAML file uses anchors or aliases; calibration files do not, so it is not read.")
    if NUMBER.fullmatch(text):
        return float(text) if re.search(r"[.eE]", text) else int(text)
    lower = text.lower()
    if lower in SPECIAL:
        return SPECIAL[lower]
    return WORDS.get(lower, text)
