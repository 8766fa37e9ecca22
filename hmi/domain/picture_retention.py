"""Which pictures go when there is no room for them any more, or no reason."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Protocol

from hmi.domain.picture import ROUTINE, PictureKind

ROUTINE_SHARE = 0.5  # what comes by itself all day leaves half of the room to snapshots and clips
MARKED_SHARE = 0.8  # what is marked leaves room for what comes next


class HeldPicture(Protocol):
    """What is needed of a picture."""

    @property
    def id(self) -> str:
        """Its id."""
        ...

    @property
    def kind(self) -> PictureKind:
        """Why it is kept."""
        ...

    @property
    def captured_at(self) -> datetime:
        """When it was taken."""
        ...

    @property
    def size_bytes(self) -> int:
        """Size of its file."""
        ...

    @property
    def is_kept(self) -> bool:
        """Whether a person marked it."""
        ...


@dataclass(frozen=True, slots=True)
class Retention:
    """How much is kept, how long, and how much of the disk must stay free."""

    most_bytes: int
    most_age: timedelta
    free_bytes: int

    @property
    def routine_bytes(self) -> int:
        """Room of what comes by itself."""
        return int(self.most_bytes * ROUTINE_SHARE)

    @property
    def marked_bytes(self) -> int:
        """Room of what is marked."""
        return int(self.most_bytes * MARKED_SHARE)


def too_many(held: Iterable[HeldPicture], now: datetime, rules: Retention) -> list[str]:
    """Return the ids of what goes: what is too old, then the oldest until the rest has room. Nothing marked goes.

    Args:
        held: all pictures of a farm in any order.
    """
    every = sorted(held, key=lambda one: (one.captured_at, one.id), reverse=True)
    marked = sum(one.size_bytes for one in every if one.is_kept)
    fresh = [one for one in every if not one.is_kept and now - one.captured_at <= rules.most_age]
    routine = _newest([one for one in fresh if one.kind in ROUTINE], rules.routine_bytes)
    wanted = [one for one in fresh if one.kind not in ROUTINE or one.id in routine]
    stays = _newest(wanted, rules.most_bytes - marked)
    return [one.id for one in every if not one.is_kept and one.id not in stays]


def _newest(newest_first: Sequence[HeldPicture], room: int) -> set[str]:
    """Return the ids of the newest that have room; behind the first that has none, nothing stays."""
    stays: set[str] = set()
    for one in newest_first:
        room -= one.size_bytes
        if room < 0:
            break
        stays.add(one.id)
    return stays
