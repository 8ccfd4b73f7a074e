"""Whatever is kept is written by `core.files`: whole or not at all, and safe on the disk."""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
OWN = {
    "core/files.py": "does it",
    "core/gate/latch.py": "the gate's own, which has a name of its own for what is unfinished",
    "core/gate/trace.py": "appends to the trace of a running gate",
    "core/robots/process.py": "locks a file that stays empty",
    "console/data_folder.py": "writes down who holds the lock, which the file itself is",
    "core/experiments/campaign.py": "appends run by run, and syncs every line",
    "console/workers/process.py": "tells the kernel, in /proc",
    "core/models.py": "a download in a temporary folder, which is checked and copied from there",
    "core/recording/mcap_writing.py": "a recording that grows for minutes; it has its name when it is finished",
    "core/recording/mcap_recovery.py": "finishes one in place: a full disk has no room for two",
    "core/recording/source.py": "a recording unpacked into a temporary folder",
    "console/options.py": "only looks whether --gate-trace can be written",
}
WRITES = {"write_text", "write_bytes", "save", "savez", "savez_compressed", "savetxt", "imwrite", "tofile"}
MODULES = {"np", "cv2", "numpy"}  # whose `save` and so on takes a path; others' methods of that name are their own


def bare_writes(tree: ast.AST) -> Iterator[int]:
    """Lines in which a file is opened for writing, or written, without being replaced as a whole."""
    replaced = {
        name.id
        for block in ast.walk(tree)
        if isinstance(block, ast.With)
        for item in block.items
        if isinstance(item.context_expr, ast.Call) and ast.unparse(item.context_expr.func).endswith("replacing")
        for name in [item.optional_vars]
        if isinstance(name, ast.Name)
    }
    for call in ast.walk(tree):
        if not isinstance(call, ast.Call):
            continue
        name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
        if name not in {"open", "dump", *WRITES}:
            continue
        owner = ast.unparse(call.func.value) if isinstance(call.func, ast.Attribute) else ""
        given = [*call.args, *(each.value for each in call.keywords if each.arg == "mode")]
        modes = [one.value for one in given if isinstance(one, ast.Constant) and isinstance(one.value, str)]
        opens = name == "open" and any(set(mode) <= set("rwaxbt+U") and set(mode) & set("wax+") for mode in modes)
        first = call.args[0] if call.args else None
        into_replaced = isinstance(first, ast.Name) and first.id in replaced
        writes = name in WRITES and (owner in MODULES or name in ("write_text", "write_bytes")) and not into_replaced
        dumps = name == "dump" and owner in ("json", "pickle")
        if opens or writes or dumps:
            yield call.lineno


def test_nothing_that_is_kept_is_written_bare() -> None:
    sources = [*ROOT.glob("core/**/*.py"), *ROOT.glob("console/**/*.py")]
    found = {
        path.relative_to(ROOT).as_posix(): lines
        for path in sources
        if (lines := list(bare_writes(ast.parse(path.read_text()))))
    }
    assert {name: lines for name, lines in found.items() if name not in OWN} == {}
    assert set(OWN) == set(found), "what is excused here writes no more"


def test_the_rule_sees_what_it_is_for() -> None:
    for bad in (
        'Path("a").write_text("")',
        'open("a", "w")',
        'path.open("ab")',
        'path.open(mode="x")',
        "np.savez_compressed(path, a=1)",
        "json.dump({}, file)",
        'cv2.imwrite("a.png", picture)',
    ):
        assert list(bare_writes(ast.parse(bad))) == [1], bad
    for good in (
        'write_atomic(path, "")',
        'path.open("rb")',
        "open(path)",
        "with replacing(path) as file:\n    np.savez(file, a=1)",
        'zipfile.ZipFile(packed, "w")',
    ):
        assert list(bare_writes(ast.parse(good))) == [], good
