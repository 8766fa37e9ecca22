"""What a check found: where, how bad, what to do, and the operation that would mend it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from hmi.mapping.coordinates import Position

BLOCKS, LOOK = 2, 3  # priorities as of alarms: 2 blocks publishing, 3 is to look at


@dataclass(frozen=True, slots=True)
class Fix:
    """An operation (``hmi.mapping.operations``) that would mend it; ``label`` is for the button."""

    label: str
    op: str
    features: tuple[str, ...]
    args: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing wrong.

    Args:
        code: stable machine-readable name, e.g. ``crosses_itself``.
        level: ``BLOCKS`` or ``LOOK``.
        feature_id, other_id: what it is about.
        text, advice: sentences for a farmer; read one after the other they make sense.
        at: ``[longitude, latitude]`` to show, if there is one place.
        fix: what would mend it, if an operation can.
    """

    code: str
    level: int
    feature_id: str
    text: str
    advice: str
    other_id: str | None = None
    at: Position | None = None
    fix: Fix | None = None

    def as_json(self) -> dict[str, Any]:
        """Return FINDING of docs/protocols/map.md."""
        fix = self.fix
        return {
            "code": self.code,
            "level": self.level,
            "feature_id": self.feature_id,
            "other_id": self.other_id,
            "text": self.text,
            "advice": self.advice,
            "at": self.at,
            "fix": fix and {"label": fix.label, "op": fix.op, "features": list(fix.features), "args": fix.args},
        }
