"""JSON from strangers: what the standard reader lets pass is refused here."""

import json
import math
from typing import Any, NoReturn

from core.errors import BadInput

LONGEST_INTEGER = 18  # digits; anything longer is no number that Beckon uses


def read_json(raw: bytes | str) -> Any:
    """UTF-8 text → value. Raises BadInput for text that is not JSON, and for NaN, infinity, repeated keys, lone
    surrogates, endless integers and endless nesting.
    """
    try:
        text = raw.decode() if isinstance(raw, bytes) else raw
        value = json.loads(
            text,
            object_pairs_hook=without_repeats,
            parse_constant=refuse_constant,
            parse_float=finite,
            parse_int=short_integer,
        )
        if "\\u" in text or isinstance(raw, str):
            json.dumps(value, ensure_ascii=False).encode()
    except UnicodeDecodeError:
        raise BadInput("The text is not UTF-8; send JSON in UTF-8.") from None
    except UnicodeEncodeError:
        raise BadInput("The text holds half a character (a lone surrogate); send complete characters.") from None
    except RecursionError:
        raise BadInput("The JSON is nested too deeply.") from None
    except ValueError:
        raise BadInput("This is not JSON; send one JSON object.") from None
    return value


def without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object's pairs → the object; a repeated key could mean two different commands."""
    value = dict(pairs)
    if len(value) < len(pairs):
        raise BadInput("A key stands twice in the JSON; send every key once.")
    return value


def refuse_constant(_: str) -> NoReturn:
    """NaN and Infinity are no JSON."""
    raise BadInput("NaN and Infinity are not numbers that can be used; send finite numbers.")


def finite(text: str) -> float:
    """1e999 would become infinity."""
    number = float(text)
    if not math.isfinite(number):
        raise BadInput("A number is too large; send finite numbers.")
    return number


def short_integer(text: str) -> int:
    if len(text) > LONGEST_INTEGER:
        raise BadInput("A number is too large; send finite numbers.")
    return int(text)
