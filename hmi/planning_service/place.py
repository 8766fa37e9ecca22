"""Where a plan was made: here or at the service, and why not there."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from hmi.domain.mission_plan import Candidate, PlannedMission

P = TypeVar("P", PlannedMission, Candidate)
HERE, SERVICE = "here", "service"


def made_here(found: P, why: str) -> P:
    """Return a plan that says why it was not made by the service; ``why`` goes on after a colon."""
    return _noted(found, HERE, f"Planned on this server: {why}.")


def made_there(found: P, took_s: float) -> P:
    """Return a plan that says that the service made it."""
    return _noted(found, SERVICE, f"Planned by the planner service in {took_s:.1f} s, checked here.")


def _noted(found: P, where: str, text: str) -> P:
    return replace(found, statistics={**found.statistics, "planned_at": {"where": where, "text": text}})
