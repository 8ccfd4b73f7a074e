"""Let a browser on this computer be loudspeaker and microphone: one page plays a sound and sends what was heard."""

import json
import secrets
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Self

import numpy as np

from core.errors import BadInput, Unavailable
from core.message import Array
from core.recording.sound_file import wav_bytes
from core.sensors.microphones import Sound
from core.sentences import static_folder

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css",
    ".js": "text/javascript",
    ".json": "application/json",
    ".svg": "image/svg+xml",
}
"""Of the page's files, by suffix: what else lies there is not given."""
MAX_RECORDING_BYTES = 40_000_000  # of a recording
PAGE_TIMEOUT_S = 600.0  # for which the page is waited for


class BrowserLoop:
    """The page, on a port of this computer alone; its address has a secret in it."""

    def __init__(self, samples: Array, rate: int) -> None:
        """`samples` (N,): what is played."""
        self.sound = wav_bytes(Sound(stamp=0.0, rate=rate, samples=samples[:, None]))
        self._heard: Array | None = None
        self._came = threading.Event()
        self._answered = threading.Event()
        self._answer: list[str] = []
        secret = secrets.token_urlsafe(12)
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), _handler(self, secret))
        self.address = f"http://127.0.0.1:{self._server.server_address[1]}/{secret}/"

    def __enter__(self) -> Self:
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._answered.wait(5.0)
        self._server.shutdown()
        self._server.server_close()

    def recorded(self, seconds: float = PAGE_TIMEOUT_S) -> Array:
        """Wait for what the page recorded, (M,) at 16 kHz. Raises Unavailable when nothing comes."""
        if not self._came.wait(seconds) or self._heard is None:
            raise Unavailable(f"No recording came from the page {self.address} within {seconds:g} s.")
        return self._heard

    def tell(self, lines: list[str]) -> None:
        """Answer the page with the lines that it shows at the end."""
        self._answer = lines
        self._answered.set()

    def take(self, body: bytes) -> list[str]:
        """A recording as 16-bit samples → what became of it, once that is known. Raises BadInput."""
        if len(body) % 2 or not body:
            raise BadInput("A recording is a row of 16-bit samples.")
        self._heard = np.frombuffer(body, "<i2").astype(float) / 32768
        self._came.set()
        self._answered.wait(PAGE_TIMEOUT_S)
        return self._answer


def _page_file(path: str) -> Path | None:
    """The file of the page at this path of the address; None where there is none."""
    folder = static_folder().resolve()
    file = (folder / (path.removeprefix("static/") or "speech-loop.html")).resolve()
    return file if file.is_relative_to(folder) and file.suffix in TYPES and file.is_file() else None


def _handler(loop: BrowserLoop, secret: str) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            path = self._path()
            if path == "orig.wav":
                self._send(200, loop.sound, "audio/wav")
            elif path is not None and (file := _page_file(path)) is not None:
                self._send(200, file.read_bytes(), TYPES[file.suffix])
            else:
                self._send(404, b"There is nothing here.", "text/plain")

        def do_POST(self) -> None:
            length = self.headers.get("Content-Length", "")
            if self._path() != "rev" or not length.isdigit() or int(length) > MAX_RECORDING_BYTES:
                self._send(404, b"There is nothing here.", "text/plain")
                return
            try:
                lines = loop.take(self.rfile.read(int(length)))
            except BadInput as trouble:
                self._send(400, str(trouble).encode(), "text/plain")
                return
            self._send(200, json.dumps(lines).encode(), "application/json")

        def _path(self) -> str | None:
            _, given, path = (*self.path.split("?")[0].split("/", 2), "", "")[:3]
            return path if secrets.compare_digest(given.encode(), secret.encode()) else None

        def _send(self, status: int, body: bytes, kind: str) -> None:
            self.send_response(status)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            """Say nothing."""

    return Handler
