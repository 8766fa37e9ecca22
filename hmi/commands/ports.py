"""What the command services need from the rest of the console, as narrow protocols."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import Any, Protocol

from hmi.domain.robot import Order, Robot
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditLine


class TickJudge(Protocol):
    """Knows which ticks of the live lane were issued and when."""

    def is_fresh(self, tick_id: str) -> bool:
        """Say whether this tick is at most 2 s old on the console's monotonic clock."""
        ...

    def age_s(self, tick_id: str) -> float | None:
        """Return the age of a tick, ``None`` for one never issued or forgotten."""
        ...


Pressers = Mapping[str, AbstractSet[str]]
"""Stop id to the user ids of who pressed it; empty ids where nobody was signed in. More than one: copies disagree."""


class FleetReader(Protocol):
    """The newest known state of every robot."""

    def robot(self, robot_id: str) -> Robot | None:
        """Return all that is known of one robot, ``None`` if it was never heard of."""
        ...


class AuditSink(Protocol):
    """Takes audit lines without ever making the caller wait."""

    def append(self, entry: AuditLine) -> None:
        """Queue one line; never blocks, never raises."""
        ...


@dataclass(frozen=True, slots=True)
class StoredMission:
    """A stored mission as it goes to a robot, with the hash the robot must read back; ``note`` is for the sender."""

    mission_id: str
    name: str
    document: Mapping[str, Any]
    sha256: str
    note: str = ""


class MissionSource(Protocol):
    """Where stored missions come from."""

    async def stored(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> StoredMission | None:
        """Return a mission of this farm as ``by`` sends it to this robot, ``None`` if there is none.

        Raises:
            OrderRefused: it must not go to this robot, with the reason.
        """
        ...

    async def sent(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> None:
        """Note that the robot holds this mission now."""
        ...


class MissionStore(MissionSource, Protocol):
    """The farm's missions, by number."""

    def forgets(self, farm_id: str, mission_id: str) -> str:
        """Say what of interrupted work sending the whole mission would forget; empty if nothing."""
        ...

    async def refused(self, farm_id: str, mission_id: str, sha256: str, by: str, why: str) -> None:
        """Note that no robot holds the document of this hash: it was refused, or did not go out."""
        ...


class StartRules(Protocol):
    """What must be true of people and records before a mission moves; answers from memory."""

    def check(self, actor: SessionInfo, robot: Robot, order: Order, checklist_id: str | None) -> None:
        """Return if this person may start or resume what the robot says it has.

        Raises:
            OrderRefused: the document is not the stored one, or the checklist is missing.
        """
        ...

    def check_flight(self, robot: Robot, order: Order) -> None:
        """Return if nothing on the map stands in the path of what flies; raises ``OrderRefused``."""
        ...

    def is_supervised(self, robot: Robot, order: Order) -> bool:
        """Say whether somebody has to look on while the robot carries out what it says it has."""
        ...


LaneEvent = Callable[[dict[str, Any]], None]
"""Hands a discrete event to every open lane, see ``{"k":"event"}`` in docs/protocols/lane.md."""
