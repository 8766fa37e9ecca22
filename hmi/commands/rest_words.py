"""What a change of the rest is called in the mission's log."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

NAMED = 6


def rest_words(kind: str, difference: Mapping[str, Any]) -> str:
    """Return one or two sentences about a planned rest."""
    if kind == "later":
        return f"Taken up again: {difference['way_m']:.0f} m way back, then on from where it stopped."
    left_out = difference["left_out"]
    if not left_out:
        return "The rest was changed."
    named = ", ".join(left_out[:NAMED]) + (f" and {len(left_out) - NAMED} more" if len(left_out) > NAMED else "")
    return f"The rest was changed: {named} left out."
