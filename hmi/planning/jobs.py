"""What others ask of the planner's geometry, by name: whoever asks first loads it, not whoever starts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hmi.domain.mission_plan import Candidate, PlannedMission, PlanWish
from hmi.domain.mission_rest import PlannedRest, RestWish


def mission(wish: PlanWish) -> PlannedMission:
    """Plan a mission; raises ``PlanRefused``."""
    from hmi.planning.mission import plan_mission

    return plan_mission(wish)


def candidate(wish: PlanWish) -> Candidate:
    """Plan a mission to look at; raises ``PlanRefused``."""
    from hmi.planning.mission import plan_candidate

    return plan_candidate(wish)


def rest(wish: RestWish) -> PlannedRest:
    """Plan the new rest of a mission; raises ``PlanRefused``."""
    from hmi.planning.rest import plan_rest

    return plan_rest(wish)


def mission_geojson(document: Mapping[str, Any], statistics: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """See ``hmi.planning.mission_map.mission_geojson``."""
    from hmi.planning import mission_map

    return mission_map.mission_geojson(document, statistics)
