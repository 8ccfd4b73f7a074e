"""The page's files: each is asked for once, until one of them changes.

The document names them under `static/v-<version>/`, where the version is that of all their contents: a browser keeps
them for good, and asks for none of them when the page is opened again. Modules import each other by relative paths,
and so stay under the same version. Under `static/` alone the browser asks each time whether they changed.
"""

import gzip
import hashlib
import os
import re
from functools import lru_cache
from pathlib import Path
from typing import Any

from fastapi import Response
from starlette.datastructures import Headers
from starlette.staticfiles import StaticFiles

from console.access.roles import needs

NO_CACHE = {"Cache-Control": "no-cache"}
FOR_GOOD = {"Cache-Control": "public, max-age=31536000, immutable"}
TEXTS = (".js", ".css", ".svg", ".json")
VERSIONED = ("css", "img", "js", "i18n")  # folders that the page is made of
COMMENT_LINES = re.compile(rb"^[ \t]*(?:/\*[^*]*\*+(?:[^/*][^*]*\*+)*/|//[^\n]*)[ \t]*$", re.MULTILINE)
MARK = "v-"  # before the version
MOST_GIVEN = 1000  # texts that are kept as they are sent


@needs("public")
class PageFiles(StaticFiles):
    """The page's files and its document. Texts travel packed."""

    def __init__(self, folder: Path) -> None:
        super().__init__(directory=folder)
        self._folder = folder
        self._version = ""  # of the document that was given out last
        self._given: dict[tuple[str, str], Response] = {}  # texts of that version: where and how they were asked for

    def document(self, name: str = "index.html") -> str:
        """Return a document, the one of all pages, which names the files as they are now."""
        version = version_of(self._folder)
        if version != self._version:
            self._version, self._given = version, {}
        text = (self._folder / name).read_text()
        for part in VERSIONED:
            text = text.replace(f'="static/{part}/', f'="static/{MARK}{self._version}/{part}/')
        return text

    async def get_response(self, path: str, scope: Any) -> Response:
        """A file by its path, with or without a version in front of it."""
        first, _, rest = path.partition(os.sep)
        if not first.startswith(MARK):
            return await super().get_response(path, scope)
        asked = path, Headers(scope=scope).get("accept-encoding", "")
        if scope["method"] == "GET" and asked in self._given:
            return self._given[asked]
        response = await super().get_response(rest, scope)
        if first == MARK + self._version and response.status_code in (200, 304):
            response.headers.update(FOR_GOOD)
            if type(response) is Response and len(self._given) < MOST_GIVEN:  # packed: the whole text is in it
                self._given[asked] = response
        return response

    def file_response(
        self, full_path: Any, stat_result: os.stat_result, scope: Any, status_code: int = 200
    ) -> Response:
        """A file that the browser may keep, but asks for each time; a text is packed where the browser takes that."""
        response = super().file_response(full_path, stat_result, scope, status_code)
        response.headers.update(NO_CACHE)
        takes_gzip = "gzip" in Headers(scope=scope).get("accept-encoding", "")
        if not takes_gzip or response.status_code != 200 or not str(full_path).endswith(TEXTS):
            return response
        headers = {name: response.headers[name] for name in ("etag", "last-modified")}
        headers |= {**NO_CACHE, "content-encoding": "gzip", "vary": "Accept-Encoding"}
        return Response(
            packed(str(full_path), stat_result.st_mtime_ns), media_type=response.media_type, headers=headers
        )


def version_of(folder: Path) -> str:
    """Return the version of the page's files: another one for any other contents."""
    files = sorted(path for name in VERSIONED for path in (folder / name).rglob("*") if path.is_file())
    digest = hashlib.sha256()
    for path in files:
        status = path.stat()
        digest.update(path.relative_to(folder).as_posix().encode())
        digest.update(_digest(path, status.st_mtime_ns, status.st_size))
    return digest.hexdigest()[:16]


@lru_cache(maxsize=1024)
def _digest(path: Path, _changed: int, _size: int) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()


@lru_cache(maxsize=512)
def packed(path: str, _changed: int) -> bytes:
    """A text file as it travels: without its comments, but on the same lines."""
    content = Path(path).read_bytes()
    if path.endswith((".js", ".css")):
        content = COMMENT_LINES.sub(lambda found: b"\n" * found[0].count(b"\n"), content)
    return gzip.compress(content, 9, mtime=0)
