"""Everything the console knows of one robot, and the frozen copy of it that is handed out."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

from hmi.domain import robot as domain
from hmi.domain.freshness import LOST_S
from hmi.domain.machine import Body, Sight, Worksite


class Part(StrEnum):
    """The pieces of a robot that change apart from each other."""

    REGISTRY = "registry"
    LINK = "link"
    FACTSHEET = "factsheet"
    TELEMETRY = "telemetry"
    STATE = "state"
    SAFETY = "safety"
    NODES = "nodes"
    BODY = "body"
    WORKSITE = "worksite"
    SIGHT = "sight"


ALL_PARTS = frozenset(Part)
RETAINED_PARTS = (Part.FACTSHEET, Part.NODES, Part.WORKSITE)


class Registered(Protocol):
    """What the store reads of a registry entry; the database row fits as it is."""

    @property
    def id(self) -> str:
        """Id on the wire."""
        ...

    @property
    def farm_id(self) -> str:
        """Farm it belongs to."""
        ...

    @property
    def name(self) -> str:
        """Name people call it."""
        ...

    @property
    def keep_out_m(self) -> float:
        """Metres people must stay away, as an admin set it."""
        ...

    @property
    def http_url(self) -> str | None:
        """Address of its own HTTP endpoint."""
        ...

    @property
    def http_token(self) -> str | None:
        """Bearer token for it."""
        ...

    @property
    def contact_name(self) -> str | None:
        """Whom to call about it."""
        ...

    @property
    def contact_phone(self) -> str | None:
        """Their number."""
        ...


@dataclass(slots=True)
class RobotRecord:
    """Everything of one robot, mutable; ``built`` is the frozen copy handed out."""

    id: str
    entry: Registered | None = None
    heard_s: float | None = None
    active_s: float = 0.0
    challenge: str | None = None
    boot: str | None = None
    is_online: bool = False
    is_gone: bool = False
    said_goodbye: bool = False
    gone_s: float = float("-inf")
    rtt_s: float | None = None
    rtt_at_s: float | None = None
    wall_offset_s: float | None = None
    rtts: deque[tuple[float, float]] = field(default_factory=deque)
    factsheet: domain.Factsheet | None = None
    telemetry: domain.Telemetry | Callable[[], domain.Telemetry] | None = None
    state: domain.RobotState | None = None
    safety: domain.SafetyState | None = None
    nodes: dict[str, domain.Node] = field(default_factory=dict)
    body: Body | Callable[[], Body] | None = None
    worksite: Worksite | None = None
    sights: dict[str, Sight] = field(default_factory=dict)
    revisions: dict[Part, int] = field(default_factory=dict)
    built: domain.Robot | None = None

    def is_heard(self, now_s: float) -> bool:
        """Say whether its heartbeats are recent enough and it did not leave."""
        return not self.is_gone and self.heard_s is not None and now_s - self.heard_s < LOST_S

    def retained(self) -> RobotRecord:
        """Return a record of what the robot says to the broker once and not again; nothing live, no entry."""
        return RobotRecord(
            self.id,
            is_gone=self.is_gone,
            said_goodbye=self.said_goodbye,
            factsheet=self.factsheet,
            nodes=self.nodes,
            worksite=self.worksite,
        )

    def fast(self) -> domain.Telemetry:
        """Return telemetry that is there, made from the wire at the first look."""
        value = self.telemetry
        assert value is not None
        if not isinstance(value, domain.Telemetry):
            value = self.telemetry = value()
        return value

    def limbs(self) -> Body | None:
        """Return joints, gauges and sightings, made from the wire at the first look."""
        value = self.body
        if value is not None and not isinstance(value, Body):
            value = self.body = value()
        return value

    def robot(self, farm_id: str, *, is_broker_up: bool) -> domain.Robot:
        """Return the frozen copy; ``farm_id`` is that of a robot which is in no registry."""
        if self.built is None:
            entry, sheet = self.entry, self.factsheet
            self.built = domain.Robot(
                id=self.id,
                is_registered=entry is not None,
                name=entry.name if entry else (sheet.name if sheet and sheet.name else self.id),
                farm_id=entry.farm_id if entry else farm_id,
                link=self._link(is_broker_up),
                factsheet=sheet,
                telemetry=None if self.telemetry is None else self.fast(),
                state=self.state,
                safety=self.safety,
                nodes=self.nodes,
                body=self.limbs(),
                worksite=self.worksite,
                sights=self.sights,
            )
        return self.built

    def _link(self, is_broker_up: bool) -> domain.LinkHealth:
        return domain.LinkHealth(
            is_online=self.is_online,
            heard_s=self.heard_s,
            challenge=self.challenge,
            challenge_s=self.heard_s,
            boot=self.boot,
            rtt_s=self.rtt_s,
            rtt_max_s=max((rtt for _, rtt in self.rtts), default=None),
            is_broker_up=is_broker_up,
            rtt_at_s=self.rtt_at_s,
            wall_offset_s=self.wall_offset_s,
            said_goodbye=self.said_goodbye,
        )
