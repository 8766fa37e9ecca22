"""The order in which a station's messages go out."""

from __future__ import annotations


class Sequence:
    """Puts what a station sends in the wrong order: of each two the second goes first."""

    def __init__(self) -> None:
        self._held: list[bytes] = []

    def through(self, payload: bytes, *, is_mixed: bool) -> list[bytes]:
        """Return what goes out now."""
        if is_mixed and not self._held:
            self._held.append(payload)
            return []
        out = [payload, *self._held] if is_mixed else [*self._held, payload]
        self._held.clear()
        return out
