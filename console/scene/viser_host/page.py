"""viser's own page, with its panel and notes hidden and the ground of our own page behind it."""

import gzip
import hashlib
from pathlib import Path

import viser

STYLE = """<style>
[data-testid^="floating-panel"],[data-floating-window],.mantine-Notifications-root,
.mantine-Paper-root[style*="position: fixed"]{display:none!important}
div[style*="background-color: rgb(20, 20, 20)"]{
background:radial-gradient(ellipse at 50% 42%,#17222d,#0a0f14)!important}
div[style*="background-color: rgb(255, 255, 255)"]{
background:radial-gradient(ellipse at 50% 42%,#ffffff,#e3eaf0)!important}
</style>"""
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; style-src 'unsafe-inline'; "
    "img-src blob: data:; connect-src 'self' blob: data:; worker-src blob:; font-src data:; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)


class ScenePage:
    """Read once, packed once."""

    def __init__(self) -> None:
        path = Path(viser.__file__).parent / "client" / "build" / "index.html"
        self.plain = path.read_text(encoding="utf-8").replace("<head>", "<head>" + STYLE, 1).encode()
        self.packed = gzip.compress(self.plain, 9, mtime=0)
        self.etag = f'"{hashlib.sha256(self.plain).hexdigest()[:32]}"'
        self.headers = {
            "etag": self.etag,
            "cache-control": "no-cache",
            "vary": "Accept-Encoding",
            "content-security-policy": POLICY,
        }
