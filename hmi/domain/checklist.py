"""What a person looks at before a robot starts: the list of each family, in the order in which one walks past it.

The one catalogue: screens, records and the server's check all read it.
"""

from __future__ import annotations

from dataclasses import dataclass

from hmi.domain.robot import Family


@dataclass(frozen=True, slots=True)
class Item:
    """One line to tick: what is true when it is ticked."""

    id: str
    text: str


_FIELD = Item("field-empty", "Nobody is in the field or on the way to it")
_BUTTON = Item("button-tested", "Emergency button on the machine tested today")
_HAND = Item("hand-button", "I have the hand controller, or I stand by the machine's button")

CHECKLISTS: dict[Family, tuple[Item, ...]] = {
    Family.WEEDER: (
        _FIELD,
        Item("laser-cover", "Laser cover is closed and whole"),
        _BUTTON,
        _HAND,
    ),
    Family.PLANTER: (
        Item("crane-empty", "Nobody is within reach of the crane or below the slope"),
        Item("crane-free", "Crane is in its dock and nothing hangs from it"),
        Item("trays", "Trays are loaded and locked"),
        _BUTTON,
    ),
    Family.UAV: (
        Item("take-off-empty", "Nobody is within 30 m of the take-off place"),
        Item("propellers", "Propellers are whole and tight, battery is locked in"),
        Item("airspace", "Airspace and wind were looked at for this flight"),
        Item("pilot", "A pilot stands by with the hand controller"),
    ),
    Family.OTHER: (_FIELD, _BUTTON, _HAND),
}


def items_of(family: Family) -> tuple[Item, ...]:
    """Return the list of a family."""
    return CHECKLISTS[family]
