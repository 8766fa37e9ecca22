"""Take features off the map."""

from __future__ import annotations

from hmi.mapping.operations.arguments import Arguments
from hmi.mapping.operations.outcome import Outcome, changed
from hmi.mapping.operations.selection import Selection, titles


def remove(selection: Selection, arguments: Arguments) -> Outcome:
    """Remove features; rows go with their parcel."""
    del arguments
    gone = {one.id: one for one in selection.chosen}
    rows = [
        one
        for one in selection.draft.values()
        if one.kind == "rows" and one.properties.get("parcel_id") in gone and one.id not in gone
    ]
    changes = tuple(changed(one, None) for one in (*selection.chosen, *rows))
    return Outcome(f"{titles(selection.chosen)} removed", changes)
