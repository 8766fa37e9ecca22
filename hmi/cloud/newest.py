"""Things of which the cloud gets the newest only: stations, cameras. What was not delivered is told as it is then."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from hmi.fiware.urn import KeyValues


class Newest(Protocol):
    """Says what to tell, and takes note of what arrived; ``what`` names the things for people."""

    what: str

    def reports(self, limit: int) -> list[KeyValues]:
        """Return what to tell now, about so many entities; until told, they come again."""
        ...

    def told(self, entities: Iterable[KeyValues]) -> None:
        """Note that these arrived."""
        ...

    def forget(self) -> None:
        """Tell everything again: the broker may have lost it, or be another one."""
        ...
