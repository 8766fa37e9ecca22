"""Topic names of edge contract v1 and the rule every id follows."""

from __future__ import annotations

import re
from enum import StrEnum
from functools import lru_cache
from typing import NamedTuple

from backend_clients.errors import WrongIdentity

PREFIX = "headland/v1"
ID_PATTERN = r"^[a-z0-9][a-z0-9_-]{0,63}$"
_ID = re.compile(ID_PATTERN)


class Up(StrEnum):
    """Kinds of message a robot sends."""

    PRESENCE = "presence"
    FACTSHEET = "factsheet"
    HEARTBEAT = "heartbeat"
    TELEMETRY = "telemetry"
    STATE = "state"
    SAFETY = "safety"
    EVENT = "event"
    NODE = "node"
    BODY = "body"
    WORKSITE = "worksite"
    SCAN = "scan"
    DETECTIONS = "detections"
    ACK = "ack"


class Down(StrEnum):
    """Kinds of message a robot receives."""

    COMMAND = "command"
    MISSION = "mission"
    STOP = "stop"
    STOP_RESET = "stop-reset"
    DRIVE = "drive"
    JOG = "jog"
    OPERATOR = "operator"
    PING = "ping"


class Address(NamedTuple):
    """A parsed topic: which robot, which kind."""

    robot: str
    kind: Up | Down


_KINDS: dict[str, Up | Down] = {**{k.value: k for k in Up}, **{k.value: k for k in Down}}


def is_id(text: str) -> bool:
    """Say whether ``text`` may name a robot, user, mission or device on the wire."""
    # fullmatch, since $ alone would let a trailing newline through
    return _ID.fullmatch(text) is not None


def check_id(text: str) -> str:
    """Return ``text`` if it is a legal id, else raise ``WrongIdentity``."""
    if not is_id(text):
        raise WrongIdentity(f"id {text[:80]!r} does not match {ID_PATTERN}")
    return text


@lru_cache(maxsize=32_768)  # a thousand robots of some twenty kinds each: checking an id costs as much as a message
def topic(robot: str, kind: Up | Down) -> str:
    """Return the topic of one robot and kind; raises ``WrongIdentity`` for a bad id."""
    return f"{PREFIX}/{check_id(robot)}/{kind.value}"


def every_robot(kind: Up | Down) -> str:
    """Return the subscription filter for one kind of message of all robots."""
    return f"{PREFIX}/+/{kind.value}"


def parse(text: str) -> Address:
    """Split a topic into robot and kind; raises ``WrongIdentity`` for anything else."""
    head, _, tail = text.rpartition("/")
    prefix, _, robot = head.rpartition("/")
    kind = _KINDS.get(tail)
    if prefix != PREFIX or kind is None:
        raise WrongIdentity(f"topic {text[:120]!r} is not {PREFIX}/<robot>/<kind>")
    return Address(check_id(robot), kind)
