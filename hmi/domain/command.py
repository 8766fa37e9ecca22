"""Orders to a robot, its answers, and the port they go through.

``hmi.commands`` makes orders; an adapter in ``hmi.ingest`` puts them on the wire. Neither knows the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol

from hmi.domain.robot import Stamp

Point3 = tuple[float, float, float]


class Action(StrEnum):
    """What a robot can be asked to do by a command."""

    START = "start"
    RESUME = "resume"
    PAUSE = "pause"
    ABORT = "abort"
    RETURN_HOME = "return_home"
    DRIVE_OPEN = "drive_open"
    DRIVE_CLOSE = "drive_close"
    GO_TO = "go_to"
    TOOL_RETRACT = "tool_retract"
    TOOL_GO_TO = "tool_go_to"
    SKIP_TARGET = "skip_target"
    STOCK_REFILLED = "stock_refilled"
    NODE_START = "node_start"
    NODE_STOP = "node_stop"
    NODE_RESTART = "node_restart"


NODE_ACTIONS = frozenset({Action.NODE_START, Action.NODE_STOP, Action.NODE_RESTART})
"""These name a node of the robot's software; they move nothing by themselves."""
PLACE_ACTIONS = frozenset({Action.GO_TO, Action.TOOL_GO_TO})
"""These name a place: ENU metres of the robot's datum."""
LEASED_ACTIONS = frozenset(Action) - {Action.PAUSE, Action.ABORT} - NODE_ACTIONS
"""Everything that can move a machine needs the lease; pausing and aborting never wait for one."""


class Outcome(StrEnum):
    """What became of an order. ``unknown`` is honest: it may have taken effect."""

    PENDING = "pending"
    ACCEPTED = "accepted"
    REJECTED = "rejected"
    TIMED_OUT = "timed_out"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class CommandOrder:
    """An instant action, ready to send."""

    robot_id: str
    command_id: str
    action: Action
    by: str
    lease_token: int
    lease_seq: int
    ttl_ms: int
    challenge: str
    mission_id: str | None = None
    mission_sha256: str | None = None
    is_supervised: bool = True
    node: str | None = None
    place: Point3 | None = None
    target: str | None = None


@dataclass(frozen=True, slots=True)
class StopOrder:
    """STOP for one robot; valid at any age."""

    robot_id: str
    stop_id: str
    by: str
    device: str
    reason: str = ""


@dataclass(frozen=True, slots=True)
class ResetOrder:
    """Clear latched presses; moves nothing."""

    robot_id: str
    reset_id: str
    stop_ids: tuple[str, ...]
    by: str
    reason: str
    lease_token: int
    lease_seq: int
    ttl_ms: int
    challenge: str


@dataclass(frozen=True, slots=True)
class DriveOrder:
    """One hold-to-run setpoint."""

    robot_id: str
    lease_token: int
    lease_seq: int
    challenge: str
    v_mps: float
    yaw_rate_radps: float


@dataclass(frozen=True, slots=True)
class JogOrder:
    """One hold-to-run setpoint of joints, rad/s or m/s by joint; joints that are not named rest."""

    robot_id: str
    lease_token: int
    lease_seq: int
    challenge: str
    rates: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class OperatorPulse:
    """The lease holder's page is open; forwarded once a second, never invented."""

    robot_id: str
    lease_token: int
    lease_seq: int
    challenge: str


Order = CommandOrder | StopOrder | ResetOrder | DriveOrder | JogOrder | OperatorPulse


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """The robot's answer to one order. ``kind`` is command, stop, stop-reset, mission or drive."""

    robot_id: str
    kind: str
    ref: str
    is_accepted: bool
    code: str
    text: str
    speed_mps: float | None
    sha256: str | None
    stamp: Stamp | None


class OrderFailed(Exception):
    """Nothing usable came back for an order; the adapter translates its client's errors into this.

    Args:
        code: stable machine-readable reason, e.g. ``not_connected`` or the robot's own code.
        text: one sentence for a person.
        is_outcome_known: False if the order may have taken effect all the same (no answer in time).
    """

    def __init__(self, code: str, text: str, *, is_outcome_known: bool) -> None:
        super().__init__(f"{code}: {text}")
        self.code = code
        self.text = text
        self.is_outcome_known = is_outcome_known


class OrderSender(Protocol):
    """Puts orders on the wire, now or not at all."""

    def send(self, order: Order) -> bool:
        """Publish ``order``; return False if there is no connection (nothing is queued)."""
        ...

    async def stop_by_http(self, order: StopOrder) -> Acknowledgement | None:
        """Send STOP by the robot's own HTTP; ``None`` if it has none or did not answer."""
        ...

    async def upload_mission(self, robot_id: str, document: dict[str, Any]) -> Acknowledgement:
        """Store a mission on the robot and return its answer with the hash it read back.

        Raises:
            OrderFailed: nothing usable came back, or the robot refused the document.
        """
        ...
