"""What went up and what did not, since the start."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class Counts:
    """Since the start.

    Args:
        states: reports of robots that arrived.
        others: entities of field stations and cameras that arrived.
        pieces: pieces that arrived.
        resent: sent again although they may have arrived: the cloud may have seen them twice.
        refused: the broker would not take them.
    """

    states: int = 0
    others: int = 0
    pieces: int = 0
    resent: int = 0
    refused: int = 0
    last_refusal: str = ""

    @property
    def arrived(self) -> int:
        """How many entities arrived, those of the map left out."""
        return self.states + self.others + self.pieces
