"""Answers that a browser saves as a file."""

import asyncio
import os
from collections.abc import Iterator
from typing import IO
from urllib.parse import quote

from fastapi import Response
from fastapi.responses import StreamingResponse

PIECE_BYTES = 2**18  # of a long file on its way


def file_named(content: bytes, name: str, kind: str) -> Response:
    return Response(content, media_type=kind, headers=named(name))


async def zip_named(packed: IO[bytes], name: str) -> Response:
    """A zip that lies on the disk, piece by piece; it is closed at the end."""
    size = await asyncio.to_thread(lambda: os.fstat(packed.fileno()).st_size)
    headers = {**named(name), "Content-Length": str(size)}
    return StreamingResponse(pieces(packed), media_type="application/zip", headers=headers)


def named(name: str) -> dict[str, str]:
    """The header by which a browser saves a download under this name (RFC 6266)."""
    plain = name.encode("ascii", "replace").decode().replace("?", "_")
    return {"Content-Disposition": f"attachment; filename=\"{plain}\"; filename*=UTF-8''{quote(name)}"}


def pieces(file: IO[bytes]) -> Iterator[bytes]:
    """A file piece by piece, in threads; it is closed at the end."""
    with file:
        while piece := file.read(PIECE_BYTES):
            yield piece
