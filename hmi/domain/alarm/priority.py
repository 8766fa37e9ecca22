"""How soon a person has to act."""

from __future__ import annotations

from enum import IntEnum


class Priority(IntEnum):
    """1 is the most urgent. Target mix of a farm's alarms: 5 % critical and high, 15 % medium, 80 % low."""

    CRITICAL = 1
    HIGH = 2
    MEDIUM = 3
    LOW = 4
