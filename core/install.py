"""The commands that install what is missing into the environment that runs Beckon.

An extra is named by the checkout or by its packages, never by the name of a distribution: what an index holds under
that name may be another program.
"""

import importlib.util
import re
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, requires
from pathlib import Path
from shlex import quote

DISTRIBUTION = "beckon-console"
CHECKOUT = Path(__file__).resolve().parents[1]
EXTRA = re.compile(r"extra\s*==\s*['\"]([^'\"]+)['\"]")


def install_extra(extra: str) -> str:
    """Return the command that installs an extra, for a shell."""
    if (CHECKOUT / "pyproject.toml").is_file():
        return install_packages("-e", f"{CHECKOUT}[{extra}]")
    return install_packages(*(line.partition(";")[0].strip() for line in requirements(extra)))


def install_packages(*arguments: str) -> str:
    """Return the command that installs packages (arguments of `pip install`), for a shell."""
    python = quote(sys.executable or "python3")
    tool = f"{python} -m pip install" if importlib.util.find_spec("pip") else f"uv pip install --python {python}"
    return " ".join((tool, *map(quote, arguments)))


def requirements(extra: str = "") -> list[str]:
    """Return the requirements of Beckon, or of one of its extras, a line each with its conditions."""
    try:
        lines: list[str] = requires(DISTRIBUTION) or []
    except PackageNotFoundError:  # a bare checkout
        project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())["project"]
        return project["optional-dependencies"].get(extra, []) if extra else project["dependencies"]
    return [line for line in lines if extra == next(iter(EXTRA.findall(line)), "")]
