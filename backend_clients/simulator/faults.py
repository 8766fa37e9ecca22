"""Faults a tester can switch on and off while the robot runs."""

from __future__ import annotations

import random
from typing import Annotated, Literal, TypeVar

import msgspec
from msgspec import Meta, Struct

Probability = Annotated[float, Meta(ge=0, le=1)]
BEYOND_SHARE = 0.97  # of the travel of the crane's stick; its soft limit is at 95 %
Kind = TypeVar("Kind", bound=Struct)
Seconds = Annotated[float, Meta(ge=0, le=600)]


class Silence(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="silence", tag_field="fault"):
    """Says nothing on MQTT; with ``http`` the HTTP endpoint does not answer either; ``deaf`` hears nothing."""

    http: bool = False
    deaf: bool = False


class Packets(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="packets", tag_field="fault"):
    """A bad network on MQTT; ``reorder`` is the share of messages held back behind the next one."""

    direction: Literal["up", "down", "both"] = "both"
    delay_s: Seconds = 0.0
    jitter_s: Seconds = 0.0
    drop: Probability = 0.0
    duplicate: Probability = 0.0
    reorder: Probability = 0.0


class Reject(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="reject", tag_field="fault"):
    """Refuses every command; never a STOP."""


class KeepsMoving(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="keeps-moving", tag_field="fault"):
    """Acknowledges STOP and pause but does not brake: a broken brake."""


class Crash(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="crash", tag_field="fault"):
    """The robot's computer dies; it boots again after ``reboot_after_s``, or when this fault is taken away."""

    reboot_after_s: Seconds | None = None


class RtkFloat(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="rtk-float", tag_field="fault"):
    """The fix drops from fixed to float."""


class LowBattery(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="low-battery", tag_field="fault"):
    """The battery falls to ``soc`` at once."""

    soc: Probability = 0.08


class ToolInterlock(
    Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="tool-interlock", tag_field="fault"
):
    """The cover of the tool is open."""


class PersonAhead(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="person-ahead", tag_field="fault"):
    """Somebody stands ``distance_m`` before the front of the machine."""

    distance_m: Annotated[float, Meta(ge=0, le=100)] = 3.0


class WeedUnsure(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="weed-unsure", tag_field="fault"):
    """A weeder cannot tell crop and weed apart."""


class CraneLimit(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="crane-limit", tag_field="fault"):
    """A planter's crane is outside its limit until it is retracted or moved by hand, or this fault is taken away."""


class TrayEmpty(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="tray-empty", tag_field="fault"):
    """A planter has ``left`` seedlings."""

    left: Annotated[int, Meta(ge=0, le=1000)] = 0


NodeName = Annotated[str, Meta(min_length=1, max_length=64)]


class NodeFailure(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="node-failure", tag_field="fault"):
    """A software node dies; a restart mends it."""

    node: NodeName


class NodeSilent(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="node-silent", tag_field="fault"):
    """Nothing is heard of a software node."""

    node: NodeName


class NodeSlow(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="node-slow", tag_field="fault"):
    """A software node runs at ``share`` of its usual rate."""

    node: NodeName
    share: Probability = 0.4


class ClockSkew(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="clock-skew", tag_field="fault"):
    """The clock of a software node's computer is ahead of the robot's."""

    node: NodeName
    offset_ms: Annotated[float, Meta(ge=-1e9, le=1e9)] = 850.0


class WrongStartOrder(
    Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="wrong-start-order", tag_field="fault"
):
    """A software node was started before what it needs; restarting it helps."""

    node: NodeName


class HardwareStop(
    Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="hardware-stop", tag_field="fault"
):
    """The red button on the machine is pressed."""


class WallClock(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="wall-clock", tag_field="fault"):
    """The robot's wall clock is wrong by ``offset_s``."""

    offset_s: Annotated[float, Meta(ge=-1e9, le=1e9)] = 3600.0


class CameraFreeze(
    Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="camera-freeze", tag_field="fault"
):
    """A camera, or all of them, keep the connection open and send no picture."""

    camera: Annotated[str, Meta(max_length=64)] = ""


class CameraGarbage(
    Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="camera-garbage", tag_field="fault"
):
    """Cameras send broken pictures."""


Fault = (
    Silence
    | Packets
    | Reject
    | KeepsMoving
    | Crash
    | RtkFloat
    | LowBattery
    | ToolInterlock
    | PersonAhead
    | WeedUnsure
    | CraneLimit
    | TrayEmpty
    | HardwareStop
    | WallClock
    | NodeFailure
    | NodeSilent
    | NodeSlow
    | ClockSkew
    | WrongStartOrder
    | CameraFreeze
    | CameraGarbage
)
NODE_FAULTS = (NodeFailure, NodeSilent, NodeSlow, ClockSkew, WrongStartOrder)
NAMES: tuple[str, ...] = (
    "silence",
    "packets",
    "reject",
    "keeps-moving",
    "crash",
    "rtk-float",
    "low-battery",
    "tool-interlock",
    "person-ahead",
    "weed-unsure",
    "crane-limit",
    "tray-empty",
    "hardware-stop",
    "wall-clock",
    "node-failure",
    "node-silent",
    "node-slow",
    "clock-skew",
    "wrong-start-order",
    "camera-freeze",
    "camera-garbage",
)
_decoder: msgspec.json.Decoder[Fault] = msgspec.json.Decoder(Fault)


def decode_fault(payload: bytes) -> Fault:
    """Return the fault described, e.g. ``{"fault": "silence", "http": true}``; raises ``msgspec.DecodeError``."""
    return _decoder.decode(payload)


class Faults:
    """The faults active on one robot, at most one of a kind."""

    def __init__(self) -> None:
        self._active: dict[str, Fault] = {}

    def set(self, fault: Fault) -> None:
        """Switch a fault on, replacing one of its kind."""
        self._active[name_of(fault)] = fault

    def clear(self, name: str | None = None) -> list[Fault]:
        """Switch one fault, or all, off; return those that were on."""
        names = [name] if name is not None else list(self._active)
        return [self._active.pop(n) for n in names if n in self._active]

    def list(self) -> list[Fault]:
        """Return the active faults."""
        return list(self._active.values())

    def of(self, kind: type[Kind]) -> Kind | None:
        """Return the active fault of a kind."""
        fault = self._active.get(str(kind.__struct_config__.tag))
        return fault if isinstance(fault, kind) else None

    def clear_node(self, node: str) -> None:
        """Take away what a restart of a software node mends."""
        for fault in self.list():
            if isinstance(fault, NODE_FAULTS) and fault.node == node and not isinstance(fault, ClockSkew):
                del self._active[name_of(fault)]

    def is_on(self, name: str) -> bool:
        """Say whether a fault is active."""
        return name in self._active

    @property
    def silence(self) -> Silence | None:
        """The silence in force."""
        fault = self._active.get("silence")
        return fault if isinstance(fault, Silence) else None

    @property
    def packets(self) -> Packets | None:
        """The bad network in force."""
        fault = self._active.get("packets")
        return fault if isinstance(fault, Packets) else None

    @property
    def is_rejecting(self) -> bool:
        """Whether every command is refused."""
        return "reject" in self._active

    @property
    def wall_offset_s(self) -> float:
        """How wrong the wall clock is."""
        fault = self._active.get("wall-clock")
        return fault.offset_s if isinstance(fault, WallClock) else 0.0


def name_of(fault: Fault) -> str:
    """Return the name a fault is switched by."""
    return str(type(fault).__struct_config__.tag)


def fate(packets: Packets | None, direction: str, rng: random.Random) -> list[float]:
    """Return for one message the delays of the copies that arrive; empty if it is lost."""
    if packets is None or packets.direction not in (direction, "both"):
        return [0.0]
    if rng.random() < packets.drop:
        return []
    copies = 2 if rng.random() < packets.duplicate else 1
    delays = []
    for _ in range(copies):
        delay = packets.delay_s + rng.random() * packets.jitter_s
        if rng.random() < packets.reorder:
            delay += 0.25  # behind what is sent in the next quarter of a second
        delays.append(delay)
    return delays
