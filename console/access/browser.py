"""Opening a browser that signs itself in: the key goes by a file that only this user can read.

A command line can be read by every user of the machine, and stays there as long as the browser runs.
"""

import contextlib
import html
import os
import time
import webbrowser
from pathlib import Path

from core.gate.scheduling import stand_back

FILE = "open.html"
PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={address}">
<title>Beckon</title>
</head>
<body><a href="{address}">Open the console</a></body>
</html>
"""


def browse(address: str, folder: Path, lasting: float) -> None:
    """Open a browser at `address`, which holds a key that is good for `lasting` seconds; its file is removed then."""
    stand_back()  # so that the browser runs like every other program
    try:
        page = written(address, folder)
    except OSError:  # a folder that cannot be written: the address that was printed is left
        return
    try:
        webbrowser.open(page.as_uri())
        time.sleep(lasting)
    finally:
        with contextlib.suppress(OSError):
            page.unlink()


def written(address: str, folder: Path) -> Path:
    """A page for this user alone that leads to `address`. Raises OSError."""
    page = folder.absolute() / FILE
    page.unlink(missing_ok=True)
    html_text = PAGE.format(address=html.escape(address))
    with os.fdopen(os.open(page, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600), "w") as file:
        file.write(html_text)
    return page
