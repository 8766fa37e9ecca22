"""What of a drawn robot is not known: old, or never told. It is drawn as a grey shade, never as solid as what is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Doubt:
    """All of a robot, or what hangs on some of its joints."""

    is_everything: bool = False
    joints: frozenset[str] = frozenset()


NOTHING, EVERYTHING = Doubt(), Doubt(is_everything=True)
