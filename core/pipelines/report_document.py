"""A report as one HTML file with everything in it: read without a network, printed to a clean PDF."""

import base64
from collections.abc import Iterable, Sequence
from html import escape

OFFLINE = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
STYLE = """
:root { color-scheme: light dark; --ink: #1b1f24; --paper: #fff; --faint: #68717c; --line: #d5dae0; --way: #0b6bcb;
  --mark: #0a7d6c; --loop: #b3541e; --band: #0a7d6c22; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e9ec; --paper: #14171a; --faint: #98a2ad; --line: #333a41;
  --way: #5aa9ff; --mark: #3fc3ae; --loop: #f09a5e; --band: #3fc3ae22; } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); margin: 0 auto;
  max-width: 900px; padding: 24px; }
h1 { font-size: 22px; } h2 { font-size: 17px; margin-top: 32px; } p, td, th, summary { overflow-wrap: break-word; }
table { border-collapse: collapse; width: 100%; } th { text-align: left; font-weight: 600; }
td, th { border-top: 1px solid var(--line); padding: 4px 12px 4px 0; vertical-align: top; }
svg { width: 100%; height: auto; max-height: 80vh; } .faint { color: var(--faint); }
.way { fill: none; stroke: var(--way); stroke-width: 1.5; vector-effect: non-scaling-stroke; }
.mark { fill: var(--band); stroke: var(--mark); stroke-width: 1.5; vector-effect: non-scaling-stroke; }
.spot { fill: none; stroke: var(--mark); vector-effect: non-scaling-stroke; }
.loop { stroke: var(--loop); stroke-width: 1.5; vector-effect: non-scaling-stroke; }
.undone { stroke-dasharray: 4 4; } .band { fill: var(--band); } .axis { stroke: var(--line); }
text { fill: var(--faint); font: 11px system-ui, sans-serif; } .map { image-rendering: pixelated; }
img { max-width: 100%; background: #fff; } pre { overflow-x: auto; font: 12px/1.4 ui-monospace, monospace; }
figure { margin: 16px 0; }
@media screen and (max-width: 480px) { body { padding: 16px; font-size: 14px; } h1 { font-size: 19px; }
  td, th { padding-right: 8px; } table { display: block; overflow-x: auto; }
  tr:has(> :nth-child(5)) { display: grid; grid-template-columns: 5em 1fr 5em 5.5em; }
  :nth-child(4) ~ td { grid-column: 1 / -1; border-top: 0; } :nth-child(4) ~ :is(th, td:empty) { display: none; } }
@page { margin: 15mm; }
@media print { :root { color-scheme: light; --ink: #1b1f24; --paper: #fff; --faint: #4a525c; --line: #c9ced4; }
  body { max-width: none; padding: 0; font-size: 10pt; } h2 { break-after: avoid; }
  svg, figure, tr { break-inside: avoid; } pre { white-space: pre-wrap; } }
"""


def document_html(title: str, parts: Iterable[str], language: str = "en") -> str:
    """Return the whole file; `parts` are HTML, the title is text, the language that of both."""
    head = (
        f'<meta charset="utf-8"><meta http-equiv="Content-Security-Policy" content="{OFFLINE}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style>"
    )
    body = "\n".join((f"<h1>{escape(title)}</h1>", *parts))
    return f'<!doctype html>\n<html lang="{language}"><head>{head}</head>\n<body>\n{body}\n</body></html>\n'


def picture_html(content: bytes, kind: str, says: str) -> str:
    """Return a picture inside the file, with what it shows; `kind` is its media type."""
    source = f"data:{kind};base64,{base64.b64encode(content).decode()}"
    words = escape(says)
    return f'<figure><img src="{source}" alt="{words}"><figcaption class="faint">{words}</figcaption></figure>'


def table_html(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of texts; a head of empty texts is left out."""
    top = f"<tr>{''.join(f'<th>{escape(one)}</th>' for one in head)}</tr>" if any(head) else ""
    lines = (f"<tr>{''.join(f'<td>{escape(one)}</td>' for one in row)}</tr>" for row in rows)
    return f"<table>{top}{''.join(lines)}</table>"
