"""What the robot can do now, and why not, as the live lane carries it."""

from __future__ import annotations

from typing import Any

from hmi.domain.robot import Robot


def present(robot: Robot, now_s: float) -> dict[str, Any] | None:
    """Return the group ``functions`` of topic ``inside``; ``None`` while nothing is known."""
    return None
