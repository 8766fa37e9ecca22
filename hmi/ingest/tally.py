"""Counts what was wrong on the wire, per reason and robot, in bounded memory."""

from __future__ import annotations

from collections import Counter

ROBOT_LIMIT = 200  # beyond it everything is counted under OTHERS, so that invented names cost nothing
OTHERS = "(others)"


class Tally:
    """How often each thing went wrong, for diagnostics; never fatal."""

    def __init__(self, robot_limit: int = ROBOT_LIMIT) -> None:
        self._limit = robot_limit
        self._by_robot: dict[str, Counter[str]] = {}
        self.total: Counter[str] = Counter()
        self.last_text: dict[str, str] = {}

    def count(self, reason: str, robot: str = "", text: str = "", number: int = 1) -> None:
        """Count ``number`` faults of one reason; ``text`` replaces the example kept of it."""
        self.total[reason] += number
        if text:
            self.last_text[reason] = text[:200]
        if not robot:
            return
        if robot not in self._by_robot and len(self._by_robot) >= self._limit:
            robot = OTHERS
        self._by_robot.setdefault(robot, Counter())[reason] += number

    def by_robot(self) -> dict[str, dict[str, int]]:
        """Return a copy: robot -> reason -> how often."""
        return {robot: dict(counter) for robot, counter in self._by_robot.items()}
