"""The arguments of an operation, read strictly: what is not understood is refused, never guessed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hmi.mapping.coordinates import MOST_VERTICES, Position, parse_line, parse_ring
from hmi.mapping.errors import BadFeature, OperationRefused


class Arguments:
    """Named values of one operation.

    Args:
        raw: as they came over the wire.
        allowed: the names the operation knows.

    Raises:
        OperationRefused: a name is not allowed.
    """

    def __init__(self, raw: Mapping[str, Any], allowed: frozenset[str]) -> None:
        for name in raw:
            if name not in allowed:
                known = f"It knows {', '.join(sorted(allowed))}." if allowed else "It takes none."
                raise OperationRefused("bad_argument", f"{str(name)[:40]!r} is no argument of this operation. {known}")
        self._raw = raw

    def number(self, name: str, least: float, most: float, default: float | None = None) -> float:
        """Return a finite number from ``least`` to ``most``.

        Raises:
            OperationRefused: missing without a default, no number, or out of range.
        """
        value = self._raw.get(name, default)
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not is_number or not least <= value <= most:  # NaN is in no range
            raise OperationRefused("bad_argument", f"{name} must be a number from {least:g} to {most:g}.")
        return float(value)

    def index(self, name: str, count: int, first: int = 0, default: int | None = None) -> int:
        """Return a whole number from ``first`` up to and without ``count``.

        Raises:
            OperationRefused: missing without a default, not whole, or out of range.
        """
        value = self._raw.get(name, default)
        if not isinstance(value, int) or isinstance(value, bool) or not first <= value < count:
            span = f"from {first} to {count - 1}" if count > first else "that exists, and there is none"
            raise OperationRefused("bad_argument", f"{name} must be a whole number {span}.")
        return value

    def line(self, name: str) -> list[Position]:
        """Return positions of a line, rounded.

        Raises:
            OperationRefused: not two or more different positions on earth.
        """
        try:
            return parse_line(self._points(name))
        except BadFeature as error:
            raise OperationRefused(error.code, f"{name}: {error.text}") from error

    def ring(self, name: str) -> list[Position]:
        """Return positions of a ring, rounded and closed.

        Raises:
            OperationRefused: not three or more different positions on earth.
        """
        try:
            return parse_ring(self._points(name))
        except BadFeature as error:
            raise OperationRefused(error.code, f"{name}: {error.text}") from error

    def feature_id(self, name: str) -> str:
        """Return the id of a feature.

        Raises:
            OperationRefused: no text.
        """
        value = self._raw.get(name)
        if not isinstance(value, str):
            raise OperationRefused("bad_argument", f"{name} must be the id of a feature.")
        return value

    def feature_ids(self, name: str) -> tuple[str, ...]:
        """Return ids of features, each once.

        Raises:
            OperationRefused: no list of texts, or empty.
        """
        value = self._raw.get(name)
        if not isinstance(value, (list, tuple)) or not value or not all(isinstance(one, str) for one in value):
            raise OperationRefused("bad_argument", f"{name} must be a list of ids of features.")
        return tuple(dict.fromkeys(value))

    def _points(self, name: str) -> object:
        value = self._raw.get(name)
        if isinstance(value, (list, tuple)) and len(value) > MOST_VERTICES:
            raise OperationRefused("too_many_corners", f"{name} has more than {MOST_VERTICES:,} points.")
        return value
