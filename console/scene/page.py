"""viser's own page, with its panel hidden."""

from __future__ import annotations

import gzip
import hashlib
from pathlib import Path

import viser

HIDE = (
    '<style>[data-testid^="floating-panel"],[data-floating-window],'
    '.mantine-Paper-root[style*="position: fixed"]{display:none!important}</style>'
)
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; style-src 'unsafe-inline'; "
    "img-src blob: data:; connect-src 'self' blob: data:; worker-src blob:; font-src data:; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)


class ScenePage:
    """Read once, packed once."""

    def __init__(self) -> None:
        path = Path(viser.__file__).parent / "client" / "build" / "index.html"
        text = path.read_text(encoding="utf-8").replace("<head>", "<head>" + HIDE, 1)
        self.plain = text.encode()
        self.packed = gzip.compress(self.plain, 9, mtime=0)
        self.etag = f'"{hashlib.sha256(self.plain).hexdigest()[:32]}"'
        self.headers = {
            "etag": self.etag,
            "cache-control": "no-cache",
            "vary": "Accept-Encoding",
            "content-security-policy": POLICY,
        }
