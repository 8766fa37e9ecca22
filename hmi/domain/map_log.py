"""Transactions on a map draft: what changed, taken back and done again.

Features are GeoJSON objects by id, as everywhere outside ``hmi.mapping``; this module never looks into them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

MapFeatures = dict[str, dict[str, Any]]


@dataclass(frozen=True, slots=True)
class FeatureChange:
    """One feature before and after; ``None`` is absent."""

    id: str
    before: dict[str, Any] | None
    after: dict[str, Any] | None

    def reversed(self) -> FeatureChange:
        """Return the change that takes this one back."""
        return FeatureChange(self.id, self.after, self.before)


@dataclass(frozen=True, slots=True)
class Transaction:
    """What one person did to a draft in one step; ``ref`` is the editor's own id of it."""

    ref: str
    label: str
    by: str
    at: datetime
    changes: tuple[FeatureChange, ...]
    is_undone: bool = False


class ChangedMeanwhile(Exception):
    """The draft does not hold what the editor saw; ``ids`` are the features that differ."""

    def __init__(self, ids: Sequence[str]) -> None:
        super().__init__(f"features changed meanwhile: {', '.join(ids)}")
        self.ids = tuple(ids)


def applied(features: Mapping[str, dict[str, Any]], changes: Sequence[FeatureChange]) -> MapFeatures:
    """Return the features with all changes made, or none.

    Raises:
        ChangedMeanwhile: a ``before`` is not what is there.
    """
    result = dict(features)
    stale = []
    for change in changes:
        if result.get(change.id) != change.before:
            stale.append(change.id)
        elif change.after is None:
            result.pop(change.id, None)
        else:
            result[change.id] = change.after
    if stale:
        raise ChangedMeanwhile(stale)
    return result


def taken_back(changes: Sequence[FeatureChange]) -> tuple[FeatureChange, ...]:
    """Return the changes that undo these, in the order in which they must be made."""
    return tuple(change.reversed() for change in reversed(changes))


def next_undo(log: Sequence[Transaction]) -> Transaction | None:
    """Return what undo takes back; ``log`` is oldest first."""
    return next((one for one in reversed(log) if not one.is_undone), None)


def next_redo(log: Sequence[Transaction]) -> Transaction | None:
    """Return what redo does again: the oldest that was taken back, for undone ones are always the newest."""
    return next((one for one in log if one.is_undone), None)
