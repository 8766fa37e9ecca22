"""What happened around an alarm."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

from hmi.domain.event import RobotEvent
from hmi.presenters.alarm_sequence import sequence

T0 = datetime(2026, 5, 20, 12, 0, tzinfo=UTC)


def entered(name: str, seconds: int, **data: object) -> RobotEvent:
    """Return that a robot entered a state."""
    return RobotEvent("r", name, "state_entered", name, "", dict(data), at_utc=T0 + timedelta(seconds=seconds))


def test_of_the_states_a_robot_enters_at_once_only_the_innermost_is_told() -> None:
    events = [
        entered("Mission", 0, is_leaf=False),
        entered("Plant site", 0, is_leaf=False),
        entered("Lower", 0, is_leaf=True),
        entered("Mission > Treat row", 9, path=["Mission", "Treat row"]),
    ]
    assert [one["text"] for one in sequence([], events, [], "")] == ["Lower", "Mission > Treat row"]


def test_what_is_told_twice_at_one_time_stands_there_once() -> None:
    events = [
        entered("Mission > Plant row > Planting", 0),
        entered("Mission / Plant row / Planting", 1),
        entered("Mission / Plant row / Planting", 30),
    ]
    assert [one["at"] % 60_000 for one in sequence([], events, [], "")] == [0, 30_000]
