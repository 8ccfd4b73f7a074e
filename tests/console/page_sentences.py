"""What the program may say to a page without a code: its errors, the fields that pages show, and all other sentences.

Read from the source alone, so nothing of the program is imported for it.
"""

import ast
import itertools
import json
import re
from collections.abc import Collection, Iterator
from pathlib import Path

from core.sentences import KEY, catalogue

ROOT = Path(__file__).parents[2]
HOLE = re.compile(r"\{\w*\}")
NAMED_HOLE = re.compile(r"\{(\w+)\}")
SENTENCE = re.compile(r"[“A-Z{].* .* .*[.!?…]", re.DOTALL)
WORDS = re.compile(r"[A-Za-z]{2,}.* .*[a-z]{2,}|\w{3,}.*[.…!?]$")  # more than the name of something

BEGINS = ("console.assembly", "console.app", "console.serve", "console.fleet_server.serve")
BY_NAME = ("console.api.", "core.experiments.", "core.speech.")  # whose modules are imported by names put together
TERMINAL = (  # said only where a program was started, or in the description of the interface
    "console.api.documentation",
    "console.cli",
    "console.listening",
    "console.logging_setup",
    "console.options",
    "core.experiments.campaign",
    "core.experiments.paper_course",
    "core.experiments.sweep",
    "core.experiments.workers",
    "core.pipelines.slam_report",
)
FIELDS = frozenset(
    {  # of messages, that pages show
        "advice",
        "ambiguity",
        "complaint",
        "detail",
        "doubt",
        "failsafe",
        "failsafe_words",
        "note",
        "notices",
        "reason",
        "refused",
        "remark",
        "says",
        "sentence",
        "trouble",
        "verdict",
        "warnings",
        "what",
        "why",
        "why_not",
        "words",
    }
)
QUIET = frozenset(
    {  # calls whose words no page shows
        "debug",
        "info",
        "warning",
        "error",
        "exception",
        "critical",
        "Meta",
        "ValueError",
        "TypeError",
        "RuntimeError",
        "AssertionError",
        "OSError",
        "NotImplementedError",
        "KeyError",
        "LookupError",
        "Query",
        "Body",
        "Path",
        "gauge",
        "quantiles",
        "Metric",
        "InjectableFault",
    }
)
UNSAID_NAMES = (
    "join",
    "name",
    "len",
    "str",
    "format",
    "abs",
    "max",
    "min",
    "sorted",
    "self",
    "x",
)  # of no use as the name of a hole
CALLS_WITH_CLAUSES = (
    "BadRecord",
    "BadReply",
    "BadLine",
    "HeadMismatch",
    "LostStep",
    "drop",
    "skip",
)  # which say part of a sentence
MAX_WAYS = 12  # in which one expression is put together


class Module:
    """One module: what it imports, and its sentences, each way in which it is put together.

    Docstrings, annotations and what is said to nobody are left out. A hole is {name}.
    """

    def __init__(self, path: Path) -> None:
        self._nodes: list[ast.AST] = []
        self._named: dict[str, list[ast.expr]] = {}  # what is assigned to a name, or returned by a function()
        self._gather(ast.parse(path.read_text()), None)
        self.kinds = [node for node in self._nodes if isinstance(node, ast.ClassDef)]

    def _gather(self, node: ast.AST, function: str | None) -> None:
        match node:
            case ast.Call() if name_called(node) in QUIET:
                return
            case ast.Expr(value=ast.Constant()):
                return
            case ast.FunctionDef(name=name):
                function = f"{name}()"
            case ast.Return(value=ast.expr() as value) if function:
                self._named.setdefault(function, []).append(value)
            case (
                ast.Assign(targets=[ast.Name(id=name)], value=value)
                | ast.AugAssign(target=ast.Name(id=name), value=value)
            ):
                self._named.setdefault(name, []).append(value)
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                self._named.setdefault(getattr(target, "id", ""), []).append(value)
                self._nodes.append(node)
                self._gather(value, function)
                return
            case ast.AnnAssign() | ast.arg():
                return
            case _:
                pass
        self._nodes.append(node)
        for child in ast.iter_child_nodes(node):
            self._gather(child, function)

    def mentioned(self) -> Iterator[str]:
        """The modules that it imports, or names in a string to import later."""
        for node in self._nodes:
            if isinstance(node, ast.ImportFrom):
                yield from (node.module or "", *(f"{node.module}.{one.name}" for one in node.names))
            elif isinstance(node, ast.Import):
                yield from (one.name for one in node.names)
            elif isinstance(node, ast.Constant) and str(node.value).startswith(("core.", "console.")):
                yield str(node.value)

    def sentences(self, errors: Collection[str]) -> Iterator[tuple[int, str]]:
        """Line and text of each; `errors` are the classes of errors whose sentence people see."""
        pieces = {id(part) for node in self._nodes if isinstance(node, ast.JoinedStr) for part in node.values}
        for node in self._nodes:
            for expression in self._said(node, errors):
                for text in self._texts(expression, 2):
                    if WORDS.search(HOLE.sub("", text)):
                        yield expression.lineno, text
            if isinstance(node, ast.Constant | ast.JoinedStr) and id(node) not in pieces:
                for text in itertools.islice(self._ways(node), MAX_WAYS):
                    if SENTENCE.fullmatch(text):
                        yield node.lineno, text

    def _said(self, node: ast.AST, errors: Collection[str]) -> Iterator[ast.expr]:
        if isinstance(node, ast.Call):
            if name_called(node) in errors:
                yield from node.args
            elif name_called(node) == "saving":
                yield ast.BinOp(node.args[0], ast.Add(), ast.Constant(": {reason}"), lineno=node.lineno)
            yield from (one.value for one in node.keywords if one.arg in FIELDS)
        elif isinstance(node, ast.Assign) and FIELDS & {
            getattr(one, "id", getattr(one, "attr", "")) for one in node.targets
        }:
            yield node.value

    def _texts(self, node: ast.expr, depth: int) -> Iterator[str]:
        """The texts that an expression may give, and those that what stands in it may give."""
        yield from itertools.islice(self._ways(node), MAX_WAYS)
        for part in ast.walk(node):
            if depth and isinstance(part, ast.Name | ast.Call):
                key = part.id if isinstance(part, ast.Name) else f"{name_called(part)}()"
                for value in self._named.get(key, ()):
                    if self._chosen(key) is not value:
                        yield from self._texts(value, depth - 1)
            elif part is not node and isinstance(part, ast.GeneratorExp | ast.ListComp | ast.List | ast.Tuple):
                for one in part.elts if isinstance(part, ast.List | ast.Tuple) else [part.elt]:
                    yield from itertools.islice(self._ways(one), MAX_WAYS)

    def _ways(self, node: ast.expr) -> Iterator[str]:
        match stripped(node):
            case ast.Constant(value=str(text)):
                yield " ".join(text.split()) if len(text) > 1 else text
            case ast.JoinedStr(values=parts):
                for chosen in itertools.product(*(list(self._parts(part)) for part in parts)):
                    yield "".join(chosen).strip()
            case ast.BinOp(left=left, op=ast.Add(), right=right):
                for chosen in itertools.product(self._parts(left), self._parts(right)):
                    yield "".join(chosen)
            case ast.IfExp(body=body, orelse=orelse):
                yield from (*self._parts(body), *self._parts(orelse))
            case ast.BoolOp(values=values):
                for value in values:
                    yield from self._parts(value)
            case ast.Call(func=ast.Attribute(value=ast.Constant(value=str(text)), attr="format" | "format_map")):
                yield re.sub(r"\{(\w*)[^}]*\}", r"{\1}", text)
            case _:
                yield f"{{{hole(node)}}}"

    def _parts(self, node: ast.expr) -> Iterator[str]:
        """The same of a piece of a text: its spaces stay."""
        match node:
            case ast.Constant(value=str(text)):
                yield text
            case ast.JoinedStr(values=parts):
                for chosen in itertools.product(*(list(self._parts(part)) for part in parts)):
                    yield "".join(chosen)
            case ast.FormattedValue(value=ast.IfExp() | ast.BoolOp() | ast.JoinedStr() as value):
                yield from self._parts(value)
            case ast.FormattedValue(value=ast.Name(id=name)) if (chosen := self._chosen(name)) is not None:
                yield from self._parts(chosen)
            case ast.FormattedValue(value=ast.BinOp(left=ast.Constant(value=str(text)), op=ast.Mult())):
                yield from ("", text)
            case ast.FormattedValue(value=value):
                yield f"{{{hole(value)}}}"
            case _:
                yield from self._ways(node)

    def _chosen(self, name: str) -> ast.IfExp | None:
        """The choice that a name stands for, where it stands for one alone."""
        match self._named.get(name):
            case [ast.IfExp(body=ast.Constant() | ast.JoinedStr(), orelse=ast.Constant() | ast.JoinedStr()) as value]:
                return value
            case _:
                return None


def name_called(node: ast.Call) -> str:
    return str(getattr(node.func, "id", getattr(node.func, "attr", "")))


def stripped(node: ast.expr) -> ast.expr:
    """What `strip` is called of, else the node itself."""
    match node:
        case ast.Call(func=ast.Attribute(value=value, attr="strip")):
            return value
        case _:
            return node


def hole(node: ast.expr) -> str:
    """A name for what an expression puts in."""
    parts = (one for one in ast.walk(node) if isinstance(one, ast.Name | ast.Attribute))
    names = (str(getattr(one, "attr", getattr(one, "id", ""))).strip("_").lower() for one in parts)
    return next((one for one in names if one not in UNSAID_NAMES), "it")


def numbered(text: str) -> str:
    """A text whose holes have a name each."""
    seen = dict[str, int]()

    def one(found: re.Match[str]) -> str:
        count = seen[found[1]] = seen.get(found[1], 0) + 1
        return found[0] if count == 1 else f"{{{found[1]}_{count}}}"

    return NAMED_HOLE.sub(one, text)


def plain(text: str) -> str:
    """A text with every hole alike."""
    return HOLE.sub("{}", text)


def sentences() -> dict[str, str]:
    """Every sentence that a page may show without a code, and where it is said first."""
    modules = reached()
    kinds = [kind for module in modules.values() for kind in module.kinds]
    errors = {"BeckonError", "Problem", *CALLS_WITH_CLAUSES}
    while more := {one.name for one in kinds if errors & {getattr(base, "id", "") for base in one.bases}} - errors:
        errors |= more
    found: dict[str, str] = {}
    for name, module in modules.items():
        for line, text in module.sentences(errors):
            found.setdefault(numbered(" ".join(text.split())), f"{name}:{line}")
    return found


def reached() -> dict[str, Module]:
    """Every module that a served console may import, but those whose words stay in a terminal, by its name."""
    paths = {name_of(path): path for room in ("core", "console") for path in (ROOT / room).rglob("*.py")}
    found, waiting = dict[str, Module](), [*BEGINS, *(name for name in paths if name.startswith(BY_NAME))]
    while waiting:
        name = waiting.pop()
        if name in paths and name not in found and not name.startswith(TERMINAL):
            found[name] = Module(paths[name])
            waiting += [name.rpartition(".")[0], *found[name].mentioned()]
    return found


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def translated() -> set[str]:
    """Every sentence that has a code or a German row, its holes alike."""
    german = {**read("de.console"), **read("de.errors")}
    return {
        plain(text).strip() for text in (*german, *(text for key, text in catalogue().items() if key.startswith(KEY)))
    }


def read(name: str) -> dict[str, str]:
    return json.loads((ROOT / f"static/i18n/{name}.json").read_bytes())
