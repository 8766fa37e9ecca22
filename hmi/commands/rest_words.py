"""What a change of the rest is called in the mission's log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hmi.domain.mission_rest import OBSTACLE, DrawnArea, Progress
from hmi.store.missions import Mission

NAMED = 6
DRAWN = "drawn_areas"  # among a mission's figures: they live and end with the document that was planned around them


def rest_words(kind: str, difference: Mapping[str, Any], areas: Sequence[DrawnArea] = ()) -> str:
    """Return one or two sentences about a planned rest."""
    if kind == "later":
        return f"Taken up again: {difference['way_m']:.0f} m way back, then on from where it stopped."
    left_out = difference["left_out"]
    named = ", ".join(left_out[:NAMED]) + (f" and {len(left_out) - NAMED} more" if len(left_out) > NAMED else "")
    changes = [f"{named} left out"] if left_out else []
    if areas:
        changes.append(f"drawn: {drawn_words(areas)}")
    return f"The rest was changed: {'; '.join(changes)}." if changes else "The rest was changed."


def drawn_words(areas: Sequence[DrawnArea]) -> str:
    """Count what was drawn."""
    obstacles = sum(one.kind == OBSTACLE for one in areas)
    counts = ((obstacles, "obstacle"), (len(areas) - obstacles, "area to leave out"))
    plural = {"obstacle": "obstacles", "area to leave out": "areas to leave out"}
    return ", ".join(f"{count} {name if count == 1 else plural[name]}" for count, name in counts if count)


def forgotten_words(mission: Mission, progress: Progress | None) -> str:
    """Say what starting fresh forgets; empty if nothing."""
    found = []
    if progress is not None and progress.is_begun:
        found.append(f"row {progress.row} of {progress.rows}, {progress.area_done_m2 / 10_000:.2f} ha done")
    areas = drawn_on(mission)
    if areas:
        found.append(drawn_words(areas))
    return "; ".join(found)


def drawn_on(mission: Mission) -> tuple[DrawnArea, ...]:
    """Return the ground somebody drew on a mission while it ran."""
    return tuple(DrawnArea.from_json(one) for one in mission.statistics.get(DRAWN, ()))
