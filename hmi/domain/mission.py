"""The life of a mission: its states, who may move it on, and what a robot's report means for it."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from hmi.domain.robot import Order, OrderStatus


class MissionStatus(StrEnum):
    """Where a mission is in its life."""

    DRAFT = "draft"
    VALIDATED = "validated"
    QUEUED = "queued"
    WAITING = "waiting"
    SENT = "sent"
    ACCEPTED = "accepted"
    RUNNING = "running"
    PAUSED = "paused"
    RESUMING = "resuming"
    DONE = "done"
    ABORTED = "aborted"
    FAILED = "failed"


class Mover(StrEnum):
    """Who moves a mission from one state to the next."""

    PERSON = "person"
    CONSOLE = "console"
    ROBOT = "robot"


_S = MissionStatus
_PERSON, _CONSOLE, _ROBOT = Mover.PERSON, Mover.CONSOLE, Mover.ROBOT
SETTLED_S = 1.0
"""Clocks are matched to within a few hundredths; a report this much later than an order knows of it."""
ENDED = frozenset({_S.DONE, _S.ABORTED, _S.FAILED})
ON_ROBOT = frozenset({_S.SENT, _S.ACCEPTED, _S.RUNNING, _S.PAUSED, _S.RESUMING})
UNDER_WAY = frozenset({_S.RUNNING, _S.PAUSED, _S.RESUMING})
EDITABLE = frozenset(_S) - ON_ROBOT - {_S.QUEUED, _S.WAITING}
"""What a robot holds or a queue waits for is not changed underneath them."""

MOVES: dict[MissionStatus, dict[MissionStatus, Mover]] = {
    _S.DRAFT: {_S.VALIDATED: _PERSON},
    _S.VALIDATED: {_S.QUEUED: _PERSON, _S.SENT: _PERSON, _S.ACCEPTED: _ROBOT},
    _S.QUEUED: {_S.VALIDATED: _PERSON, _S.WAITING: _CONSOLE, _S.SENT: _CONSOLE},
    _S.WAITING: {_S.VALIDATED: _PERSON, _S.QUEUED: _CONSOLE, _S.SENT: _CONSOLE},
    _S.SENT: {_S.ACCEPTED: _ROBOT, _S.RUNNING: _ROBOT, _S.VALIDATED: _ROBOT, _S.FAILED: _ROBOT, _S.SENT: _PERSON},
    _S.ACCEPTED: {_S.RUNNING: _ROBOT, _S.PAUSED: _ROBOT, _S.VALIDATED: _ROBOT, _S.ABORTED: _ROBOT, _S.FAILED: _ROBOT,
                  _S.SENT: _PERSON},
    _S.RUNNING: {_S.PAUSED: _ROBOT, _S.DONE: _ROBOT, _S.ABORTED: _ROBOT, _S.FAILED: _ROBOT},
    _S.PAUSED: {_S.RESUMING: _PERSON, _S.RUNNING: _ROBOT, _S.DONE: _ROBOT, _S.ABORTED: _ROBOT, _S.FAILED: _ROBOT,
                _S.ACCEPTED: _ROBOT, _S.SENT: _PERSON},
    _S.RESUMING: {_S.RUNNING: _ROBOT, _S.PAUSED: _ROBOT, _S.DONE: _ROBOT, _S.ABORTED: _ROBOT, _S.FAILED: _ROBOT},
    _S.DONE: {_S.SENT: _PERSON, _S.ACCEPTED: _ROBOT, _S.RUNNING: _ROBOT},
    _S.ABORTED: {_S.SENT: _PERSON, _S.ACCEPTED: _ROBOT, _S.RUNNING: _ROBOT, _S.PAUSED: _PERSON},
    _S.FAILED: {_S.SENT: _PERSON, _S.ACCEPTED: _ROBOT, _S.RUNNING: _ROBOT, _S.PAUSED: _PERSON},
}  # fmt: skip
"""The only table of moves. An ended mission may be sent again: it starts fresh, its log keeps both lives.
One that was interrupted may be taken up again: it is paused then, before the way back to where it stopped.
"""


@dataclass(frozen=True, slots=True)
class MissionChange:
    """One step in the life of a mission: what, by whom, when and why."""

    mission_id: str
    before: MissionStatus
    after: MissionStatus
    mover: Mover
    by: str
    at: datetime
    why: str = ""


class BadMove(Exception):
    """A mission cannot go from this state to that one, or not by this hand."""


def check_move(before: MissionStatus, after: MissionStatus, mover: Mover) -> None:
    """Return if the table has this move.

    Raises:
        BadMove: with a sentence that names both states.
    """
    needed = MOVES[before].get(after)
    if needed is None:
        raise BadMove(f"A mission that is {before.value} cannot become {after.value}.")
    if needed is not mover:
        raise BadMove(f"Only the {needed.value} can make a {before.value} mission {after.value}.")


_REPORTED: dict[OrderStatus, MissionStatus] = {
    OrderStatus.LOADED: _S.ACCEPTED,
    OrderStatus.RUNNING: _S.RUNNING,
    OrderStatus.PAUSED: _S.PAUSED,
    OrderStatus.DONE: _S.DONE,
    OrderStatus.ABORTED: _S.ABORTED,
    OrderStatus.FAILED: _S.FAILED,
}
_WHY: dict[OrderStatus, str] = {
    OrderStatus.LOADED: "The robot has read it back.",
    OrderStatus.RUNNING: "The robot drives.",
    OrderStatus.PAUSED: "The robot paused.",
    OrderStatus.DONE: "The robot reached the end.",
    OrderStatus.ABORTED: "The robot ended it early.",
    OrderStatus.FAILED: "The robot could not go on.",
}


@dataclass(frozen=True, slots=True)
class OpenMission:
    """What following a mission needs: its state, and the document the robot should hold."""

    mission_id: str
    status: MissionStatus
    robot_id: str | None
    sha256: str
    acted_s: float | None = None
    """When a person's last order for it was accepted, on the console's monotonic clock."""


def reported_move(
    mission: OpenMission, order: Order | None, reported_s: float | None = None
) -> tuple[tuple[MissionStatus, ...], str] | None:
    """Return the states a robot's report takes its mission through, with the reason; ``None`` if nothing changes.

    More than one state where the console was away while one of them passed.

    Args:
        mission: one that this robot may hold.
        order: what the robot says it has, ``None`` if it has no mission.
        reported_s: when that was true, on the console's monotonic clock.
    """
    if order is None or order.status is OrderStatus.NONE or order.mission_id != mission.mission_id:
        return _gone(mission, order)
    if order.sha256 != mission.sha256:
        # an older document of the same mission: says nothing about the one stored now
        return None
    after = _REPORTED[order.status]
    if after is mission.status or _is_before_news(mission, order.status, reported_s):
        return None
    return _through(mission.status, after, _WHY[order.status])


def _is_before_news(mission: OpenMission, reported: OrderStatus, reported_s: float | None) -> bool:
    """Say whether a report is older than what a person did since: the last life of a mission sent again."""
    if mission.status is MissionStatus.SENT:
        return reported in (OrderStatus.PAUSED, OrderStatus.DONE, OrderStatus.ABORTED, OrderStatus.FAILED)
    if mission.status is not MissionStatus.RESUMING or reported is not OrderStatus.PAUSED:
        return False
    # the robot runs from the moment it accepted; a pause reported later is a new one
    return mission.acted_s is None or reported_s is None or reported_s < mission.acted_s + SETTLED_S


def _through(before: MissionStatus, after: MissionStatus, why: str) -> tuple[tuple[MissionStatus, ...], str] | None:
    """Find the way in the table; what the table lacks is not believed."""
    if MOVES[before].get(after) is Mover.ROBOT:
        return (after,), why
    for middle, mover in MOVES[before].items():
        if mover is Mover.ROBOT and middle not in ENDED and MOVES[middle].get(after) is Mover.ROBOT:
            return (middle, after), why
    return None


def _gone(mission: OpenMission, order: Order | None) -> tuple[tuple[MissionStatus, ...], str] | None:
    """The robot does not have the mission any more."""
    has_other = order is not None and order.status is not OrderStatus.NONE
    if mission.status is MissionStatus.ACCEPTED:
        why = "The robot has another mission now." if has_other else "The robot does not have it any more."
        return (MissionStatus.VALIDATED,), why
    if mission.status in UNDER_WAY and has_other:
        return (MissionStatus.ABORTED,), "The robot took another mission."
    if mission.status in UNDER_WAY:
        return (MissionStatus.FAILED,), "The robot lost the mission."
    return None
