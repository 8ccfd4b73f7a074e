"""QR codes of sign-in links, for phones."""

import io

import segno


def rows(address: str) -> list[str]:
    """The code's modules, row by row: "1" dark, "0" light, without a margin."""
    code = segno.make_qr(address, error="m")
    return ["".join("1" if module else "0" for module in row) for row in code.matrix]


def drawn(address: str) -> str:
    """The same for a terminal, two modules to a character, with its margin."""
    text = io.StringIO()
    segno.make_qr(address, error="m").terminal(text, compact=True)
    return text.getvalue()
