"""JSON as Orion reads and writes it: numbers are doubles with nine decimals, repeated members are refused."""

from __future__ import annotations

import json
import math
from typing import Any, TypeAlias

from backend_clients.simulator.context_broker.refusal import bad_request, parse_error

Json: TypeAlias = Any  # str | float | bool | None | list[Json] | dict[str, Json]
EXACT = 2**53  # larger whole numbers lose digits
DECIMALS = 9


class _Members(dict[str, Json]):
    """An object that remembers a member given twice."""

    repeated: str | None = None


def read_object(body: bytes) -> dict[str, Json]:
    """Return the object of a body; anything else is a ``ParseError``."""
    found = read(body)
    if not isinstance(found, dict):
        raise parse_error()
    if isinstance(found, _Members) and found.repeated is not None:
        raise bad_request(f"duplicated attribute /{found.repeated}/")
    return found


def read(body: bytes) -> Json:
    """Return any JSON value; NaN, infinity and broken text are a ``ParseError``."""
    try:
        return json.loads(
            body.decode("utf-8"),
            parse_constant=_no_constant,
            parse_float=_float,
            parse_int=_int,
            object_pairs_hook=_members,
        )
    except (ValueError, RecursionError) as error:
        raise parse_error() from error


def write(value: Json) -> bytes:
    """Return the body for a value, in Orion's way of writing numbers."""
    return json.dumps(stored(value), ensure_ascii=False, separators=(",", ":")).encode("utf-8", "surrogatepass")


def stored(value: Json) -> Json:
    """Return the value with each number as Orion gives it back: 1.0 is 1, nine decimals, no negative zero."""
    if isinstance(value, bool) or value is None or isinstance(value, str):
        return value
    if isinstance(value, int | float):
        return _number(value)
    if isinstance(value, list):
        return [stored(item) for item in value]
    return {key: stored(item) for key, item in value.items()}


def _number(value: float) -> float:
    if isinstance(value, int) and abs(value) <= EXACT:
        return value
    double = float(value)
    if double.is_integer():
        return int(double)
    short = round(double, DECIMALS)
    return int(short) if short.is_integer() else short


def _members(pairs: list[tuple[str, Json]]) -> _Members:
    found = _Members(pairs)
    if len(found) != len(pairs):
        seen: set[str] = set()
        found.repeated = next(name for name, _ in pairs if name in seen or seen.add(name))  # type: ignore[func-returns-value]
    return found


def _no_constant(text: str) -> None:
    raise ValueError(text)


def _float(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(text)
    return value


def _int(text: str) -> float:
    return int(text) if len(text) < 17 else _float(text)
