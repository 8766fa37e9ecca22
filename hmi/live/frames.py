"""The frames of the live lane, see docs/protocols/lane.md: strict on what browsers send, encoded once for all."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated, Any

import msgspec

from hmi.domain.ids import ID_PATTERN, is_id

MAX_CLIENT_BYTES = 8192  # an honest frame has under 300 bytes, a subscription of 50 topics under 4 KB
MAX_TOPICS = 64
MAX_HERE = 100  # robots one frame keeps control of
MAX_JOINTS = 16
FLEET = "fleet"
POSES = "poses"
ALARMS = "alarms"
ROBOT = "robot/"
INSIDE = "inside/"

RobotId = Annotated[str, msgspec.Meta(pattern=ID_PATTERN + r"(?!\n)")]
TickId = Annotated[str, msgspec.Meta(min_length=1, max_length=80)]
JointName = Annotated[str, msgspec.Meta(min_length=1, max_length=80)]
Speed = Annotated[float, msgspec.Meta(ge=-2, le=2)]


class Sub(msgspec.Struct, frozen=True, tag_field="k", tag="sub", forbid_unknown_fields=True):
    """Replace the subscription."""

    topics: Annotated[list[Annotated[str, msgspec.Meta(max_length=80)]], msgspec.Meta(max_length=MAX_TOPICS)]


class Ping(msgspec.Struct, frozen=True, tag_field="k", tag="ping", forbid_unknown_fields=True):
    """Measure the round trip; ``m`` is the newest tick time the browser has, which tells how far it is behind."""

    n: Annotated[int, msgspec.Meta(ge=0, le=2**53)]
    m: float | None = None


class Here(msgspec.Struct, frozen=True, tag_field="k", tag="here", forbid_unknown_fields=True):
    """A page of the lease holder is open; one frame may speak for several robots."""

    tick: TickId
    robot: RobotId | None = None
    robots: Annotated[list[RobotId], msgspec.Meta(max_length=MAX_HERE)] = []

    def each(self) -> list[str]:
        """Return the robots it speaks for."""
        return [*([] if self.robot is None else [self.robot]), *self.robots]


class Drive(msgspec.Struct, frozen=True, tag_field="k", tag="drive", forbid_unknown_fields=True):
    """One hold-to-run setpoint: ``v`` in m/s, ``w`` in rad/s.

    ``picture`` is the age in ms of the camera picture the person steers by, ``None`` where none is in use.
    """

    robot: RobotId
    v: Speed
    w: Speed
    tick: TickId
    picture: Annotated[float, msgspec.Meta(ge=0)] | None = None


class Jog(msgspec.Struct, frozen=True, tag_field="k", tag="jog", forbid_unknown_fields=True):
    """One hold-to-run setpoint of joints by name: rad/s or m/s; ``picture`` as of ``Drive``."""

    robot: RobotId
    rates: Annotated[dict[JointName, Speed], msgspec.Meta(min_length=1, max_length=MAX_JOINTS)]
    tick: TickId
    picture: Annotated[float, msgspec.Meta(ge=0)] | None = None


ClientFrame = Sub | Ping | Here | Drive | Jog
_decoder: msgspec.json.Decoder[ClientFrame] = msgspec.json.Decoder(ClientFrame)
_encoder = msgspec.json.Encoder()


class BadFrame(ValueError):
    """A browser sent something that is no frame."""


def decode_client(text: str | bytes) -> ClientFrame:
    """Return a frame of a browser; raises ``BadFrame`` for anything else."""
    if len(text) > MAX_CLIENT_BYTES:
        raise BadFrame(f"{len(text)} bytes")
    try:
        return _decoder.decode(text)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise BadFrame(str(error)[:200]) from error


def is_topic(topic: str) -> bool:
    """Say whether a browser may ask for this topic."""
    if topic in (FLEET, POSES, ALARMS):
        return True
    kind, slash, robot_id = topic.partition("/")
    return kind + slash in (ROBOT, INSIDE) and is_id(robot_id)


def encode(frame: Mapping[str, Any]) -> str:
    """Return a frame as text."""
    return _encoder.encode(frame).decode()


def piece(value: Any) -> str:
    """Return one value as JSON text, to be put together with others."""
    return _encoder.encode(value).decode()


def delta(revision: int, topic: str, groups: str) -> str:
    """Return a delta of one topic from groups that are JSON already; topic names need no escapes."""
    return f'{{"k":"delta","rev":{revision},"d":{{"{topic}":{groups}}}}}'


def snapshot(revision: int, topics: Iterable[tuple[str, str]]) -> str:
    """Return the full state of several topics from JSON that is cached per topic."""
    body = ",".join(f'"{topic}":{state}' for topic, state in topics)
    return f'{{"k":"snap","rev":{revision},"d":{{{body}}}}}'
