"""Topic names of field sensor contract v1.

They have one level more than those of a robot (``headland/v1/{robot}/{kind}``), so no subscription for robots ever
matches a station, and no station can be taken for a robot, not even one called ``field``.
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

from backend_clients.edge.topics import check_id
from backend_clients.errors import WrongIdentity

PREFIX = "headland/v1/field"


class Up(StrEnum):
    """Kinds of message a station sends."""

    ABOUT = "about"
    DATA = "data"
    FRAME = "frame"
    ACK = "ack"


class Down(StrEnum):
    """Kinds of message a station receives."""

    NOTICE = "notice"
    TRIGGER = "trigger"


class Address(NamedTuple):
    """A parsed topic: which station, which kind."""

    station: str
    kind: Up | Down


_KINDS: dict[str, Up | Down] = {**{k.value: k for k in Up}, **{k.value: k for k in Down}}


def topic(station: str, kind: Up | Down) -> str:
    """Return the topic of one station and kind; raises ``WrongIdentity`` for a bad id."""
    return f"{PREFIX}/{check_id(station)}/{kind.value}"


def every_station(kind: Up | Down) -> str:
    """Return the subscription filter for one kind of message of all stations."""
    return f"{PREFIX}/+/{kind.value}"


def parse(text: str) -> Address:
    """Split a topic into station and kind; raises ``WrongIdentity`` for anything else."""
    head, _, tail = text.rpartition("/")
    prefix, _, station = head.rpartition("/")
    kind = _KINDS.get(tail)
    if prefix != PREFIX or kind is None:
        raise WrongIdentity(f"topic {text[:120]!r} is not {PREFIX}/<station>/<kind>")
    return Address(check_id(station), kind)
