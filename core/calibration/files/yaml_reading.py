"""YAML of camera files: ROS camera_info, Kalibr's camchain, OpenCV's FileStorage. Read only, within limits."""

import re
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer, MaxDepthExceededError
from ruamel.yaml.constructor import DuplicateKeyError, SafeConstructor
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import AliasEvent

from core.errors import BadInput

MAX_CHARACTERS = 2**17
MAX_DEPTH = 12
MAX_NODES = 20_000  # scalars, lists and mappings, those behind an alias counted wherever it stands
# OpenCV's "%YAML:1.0" is no directive of YAML; "%YAML 1.1" would turn 010 into 8 and 1e-5 into a text.
VERSION = re.compile(r"\A((?:[ \t\r]*(?:#[^\n]*)?\n)*)%YAML[: ][ \t]*1\.\d[ \t]*(?=[\r\n]|\Z)")
# Tabs that indent nothing are blanks.
TABS = re.compile(r"(?<=[^ \t\n])[ \t]*\t[ \t]*|^[ \t]*\t[ \t]*(?=#|\r?$)", re.MULTILINE)
OPENCV_TAGS = "tag:yaml.org,2002:opencv-"  # !!opencv-matrix, !!opencv-nd-matrix …
UNREADABLE = (ValueError, TypeError, LookupError, AttributeError, RecursionError)  # a tag whose value does not fit it


class LimitedComposer(Composer):
    """Composes nodes up to a number of them, so that no aliases unfold into more."""

    def __init__(self, loader: Any = None) -> None:
        super().__init__(loader)
        self.warn_double_anchors = False  # YAML allows a name to be given again
        self._nodes = 0
        self._sizes: dict[int, int] = {}  # nodes within a complete node, by its identity

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Compose the next node. Raises BadInput beyond `MAX_NODES`."""
        is_alias = self.parser.check_event(AliasEvent)
        before = self._nodes
        node = super().compose_node(parent, index)
        if is_alias:
            self._nodes += self._sizes.get(id(node), MAX_NODES)
        else:
            self._nodes += 1
            self._sizes[id(node)] = self._nodes - before
        if self._nodes > MAX_NODES:
            raise BadInput(f"The YAML holds more than {MAX_NODES} values; that is no camera file.")
        return node


class CameraFileConstructor(SafeConstructor):
    """Constructs plain values only; OpenCV's matrices stay mappings of rows, cols and data."""


def _opencv_mapping(constructor: SafeConstructor, _suffix: str, node: Any) -> dict[Any, Any]:
    return constructor.construct_mapping(node, deep=True)


CameraFileConstructor.add_multi_constructor(OPENCV_TAGS, _opencv_mapping)


def read_yaml(text: str) -> dict[str, Any]:
    """Text → its top mapping, by the rules of YAML 1.2, whatever version it declares. Raises BadInput."""
    if len(text) > MAX_CHARACTERS:
        raise BadInput(f"The YAML is longer than {MAX_CHARACTERS // 1024} kB; that is no camera file.")
    reader = YAML(typ="safe", pure=True)
    reader.Composer, reader.Constructor, reader.max_depth = LimitedComposer, CameraFileConstructor, MAX_DEPTH
    try:
        value = reader.load(TABS.sub(" ", VERSION.sub(r"\1", text.lstrip("\ufeff"))))
    except DuplicateKeyError as wrong:
        raise BadInput(f"The YAML gives the same name twice{_line(wrong)}.") from None
    except MaxDepthExceededError as wrong:
        raise BadInput(f"The YAML is nested deeper than {MAX_DEPTH} levels{_line(wrong)}.") from None
    except YAMLError as wrong:
        raise BadInput(f"It is not valid YAML{_line(wrong)}.") from None
    except UNREADABLE:
        raise BadInput("The YAML holds a value that cannot be read.") from None
    if not isinstance(value, dict):
        raise BadInput("The YAML is not one mapping of names to values.")
    return value


def _line(wrong: YAMLError) -> str:
    mark = wrong.problem_mark if isinstance(wrong, MarkedYAMLError) else None
    return "" if mark is None else f" (line {mark.line + 1})"
