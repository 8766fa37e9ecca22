"""The three families: a laser weeder, a tree planter with a crane, and a UAV."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from backend_clients.simulator.planter_profile import PLANTER
from backend_clients.simulator.profile import Family, Profile
from backend_clients.simulator.uav_profile import UAV
from backend_clients.simulator.weeder_profile import WEEDER

FAMILIES: dict[Family, Profile] = {one.family: one for one in (WEEDER, PLANTER, UAV)}


@cache
def lean(family: Family) -> Profile:
    """Return a family that is put on its path instead of being steered along it."""
    profile = FAMILIES[family]
    return replace(profile, motion=replace(profile.motion, is_on_rails=True))


__all__ = ["FAMILIES", "PLANTER", "UAV", "WEEDER", "lean"]
