"""Which kind of machine a robot is."""

from __future__ import annotations

from enum import StrEnum


class Family(StrEnum):
    """Kind of machine; decides words and tiles, never safety."""

    WEEDER = "weeder"
    PLANTER = "planter"
    UAV = "uav"
    OTHER = "other"
