"""Help: the pages of static/docs, rendered for the browser, offline."""

from __future__ import annotations

import html
import re
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse, RedirectResponse

from console.access.roles import needs
from console.api.page_files import NO_CACHE
from console.http.problems import Problem, wanted_page
from core.sentences import static_folder

if TYPE_CHECKING:
    from markdown_it import MarkdownIt
    from markdown_it.token import Token

help_pages = APIRouter()

PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title} · Beckon</title>
<link rel="icon" href="{root}static/img/beckon.svg" type="image/svg+xml">
<link rel="stylesheet" href="{root}static/css/tokens.css">
<link rel="stylesheet" href="{root}static/css/docs.css">
<link rel="stylesheet" href="{root}static/css/help/help.css">
</head>
<body>
<nav><a href="{root}static/docs/index.md">Documentation</a> <a href="{root}">Console</a></nav>
{contents}<main class="docs">
{body}
</main>
</body>
</html>
"""

CONTENTS = '<nav class="contents" aria-label="Contents"><ul>{entries}</ul></nav>\n'
MIN_CHAPTERS = 4  # of a page that has a table of contents


@help_pages.get("/static/docs/{path:path}", include_in_schema=False)
@needs("public")
async def help_page(path: str, request: Request) -> Response:
    """A page of the documentation, or a picture in it. Links between pages are those of the files.

    A browser that is signed in gets a page within Help.
    """
    folder = (static_folder() / "docs").resolve()
    file = (folder / path.replace("\0", "")).resolve()
    if not file.is_relative_to(folder) or not file.is_file():
        raise Problem(404, "There is no such page; /help has the table of contents.")
    if file.suffix != ".md":
        return FileResponse(file, headers=NO_CACHE)
    root = "../" * (len(file.relative_to(folder).parts) + 1)
    if wanted_page(request.scope) is not None and request.scope["person"] is not None:
        return RedirectResponse(f"{root}help#{path}", 303)
    return Response(rendered(file, file.stat().st_mtime_ns, root), media_type="text/html", headers=NO_CACHE)


@lru_cache(maxsize=64)
def rendered(file: Path, _changed: int, root: str) -> str:
    return as_page(file.read_text(encoding="utf-8"), root)


def reader() -> MarkdownIt:
    """Markdown with tables, and with code that the keyboard can scroll."""
    from markdown_it import MarkdownIt  # late: it is there for the first page that is read

    made = MarkdownIt("commonmark").enable("table")
    for block in ("fence", "code_block"):
        made.add_render_rule(block, scrolled_code)
    return made


def as_page(text: str, root: str) -> str:
    """Markdown → a page of the documentation; `root` leads to the console."""
    title = next((line[2:] for line in text.splitlines() if line.startswith("# ")), "Documentation")
    markdown = reader()
    tokens = markdown.parse(text)
    chapters = numbered(tokens)
    entries = "".join(f'<li><a href="#{anchor}">{html.escape(name)}</a></li>' for anchor, name in chapters)
    contents = CONTENTS.format(entries=entries) if len(chapters) >= MIN_CHAPTERS else ""
    body = markdown.renderer.render(tokens, markdown.options, {})
    return PAGE.format(title=html.escape(title), root=root, body=body, contents=contents)


def numbered(tokens: Sequence[Token]) -> list[tuple[str, str]]:
    """Give chapters an anchor, blocks that scroll a place in the order of Tab, and no column an empty head.

    The chapters: anchor and name.
    """
    chapters: dict[str, str] = {}
    for token, inside, end in zip(tokens, tokens[1:], tokens[2:], strict=False):
        if token.type == "heading_open" and token.tag == "h2":
            anchor = re.sub(r"\W+", "-", inside.content.lower()).strip("-")
            anchor += "-" * (anchor in chapters)
            token.attrSet("id", anchor)
            chapters[anchor] = inside.content.replace("`", "")
        elif token.type == "th_open" and not inside.content:
            token.tag = end.tag = "td"
        elif token.type == "table_open":
            token.attrSet("tabindex", "0")
    return list(chapters.items())


def scrolled_code(_: object, tokens: Sequence[Token], number: int, _options: object, _env: object) -> str:
    return f'<pre tabindex="0"><code>{html.escape(tokens[number].content)}</code></pre>\n'
