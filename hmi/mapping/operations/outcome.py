"""What an operation comes to: the changes of one transaction and its label."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from hmi.mapping.feature import MapFeature


@dataclass(frozen=True, slots=True)
class Change:
    """One feature before and after; ``None`` where it is not on the map."""

    id: str
    before: MapFeature | None
    after: MapFeature | None


@dataclass(frozen=True, slots=True)
class Outcome:
    """One transaction, not yet applied.

    Args:
        label: short text for the log, such as ``Split Nordfeld 12 in two``.
        changes: one for each feature touched, at least one.
    """

    label: str
    changes: tuple[Change, ...]

    def applied_to(self, draft: Mapping[str, MapFeature]) -> dict[str, MapFeature]:
        """Return the draft with the changes made."""
        return _replaced(draft, {change.id: change.after for change in self.changes})

    def taken_back_from(self, draft: Mapping[str, MapFeature]) -> dict[str, MapFeature]:
        """Return the draft with the changes undone."""
        return _replaced(draft, {change.id: change.before for change in self.changes})


def changed(before: MapFeature, after: MapFeature | None) -> Change:
    """Return the change of a feature that is on the map."""
    return Change(before.id, before, after)


def added(after: MapFeature) -> Change:
    """Return the change that brings a new feature."""
    return Change(after.id, None, after)


def _replaced(draft: Mapping[str, MapFeature], new: Mapping[str, MapFeature | None]) -> dict[str, MapFeature]:
    merged = {**draft, **new}
    return {key: one for key, one in merged.items() if one is not None}
