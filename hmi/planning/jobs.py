"""What others ask of the planner's geometry, by name: whoever asks first loads it, not whoever starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hmi.domain.mission_plan import Candidate, PlannedMission, PlanWish
from hmi.domain.mission_rest import PlannedRest, RestWish
from hmi.planning.progress_note import ProgressNote


def mission(wish: PlanWish, note: str) -> PlannedMission:
    """Plan a mission; raises ``PlanRefused``.

    Args:
        note: file that says how far it is, see ``ProgressNote``.
    """
    from hmi.planning.mission import plan_mission

    with ProgressNote(Path(note)) as tell:
        return plan_mission(wish, tell=tell)


def candidate(wish: PlanWish, note: str) -> Candidate:
    """Plan a mission to look at; as ``mission``."""
    from hmi.planning.mission import plan_candidate

    with ProgressNote(Path(note)) as tell:
        return plan_candidate(wish, tell)


def given_mission(wish: PlanWish, segments: Sequence[Mapping[str, Any]], notes: Sequence[str] = ()) -> PlannedMission:
    """Check a path that was planned elsewhere and make a mission of it; see ``hmi.planning.given_path``."""
    from hmi.planning.given_path import checked_mission

    return checked_mission(wish, segments, notes)


def given_candidate(wish: PlanWish, segments: Sequence[Mapping[str, Any]], notes: Sequence[str] = ()) -> Candidate:
    """Check a path that was planned elsewhere, to look at; see ``hmi.planning.given_path``."""
    from hmi.planning.given_path import checked_candidate

    return checked_candidate(wish, segments, notes)


def rest(wish: RestWish) -> PlannedRest:
    """Plan the new rest of a mission; raises ``PlanRefused``."""
    from hmi.planning.rest import plan_rest

    return plan_rest(wish)


def mission_geojson(document: Mapping[str, Any], statistics: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """See ``hmi.planning.mission_map.mission_geojson``."""
    from hmi.planning import mission_map

    return mission_map.mission_geojson(document, statistics)
