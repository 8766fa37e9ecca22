"""Scalars and the header that messages of edge contract v1 share.

Lengths in metres, angles in radians, times in milliseconds unless the name says otherwise.
"""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import UNSET, Meta, Struct, UnsetType

from backend_clients.edge.topics import ID_PATTERN

# Python's $ also matches before a final newline; the look-ahead closes that hole and is valid in JSON Schema
Id = Annotated[str, Meta(pattern=ID_PATTERN + r"(?!\n)", description="lower-case id")]
Text = Annotated[str, Meta(max_length=400)]
Name = Annotated[str, Meta(max_length=80)]
Count = Annotated[int, Meta(ge=0, le=2**53)]
Share = Annotated[float, Meta(ge=0, le=1, description="0 to 1")]
Metres = Annotated[float, Meta(ge=-1e7, le=1e7)]
Positive = Annotated[float, Meta(ge=0, le=1e9)]
Radians = Annotated[float, Meta(ge=-1e3, le=1e3)]
LatDeg = Annotated[float, Meta(ge=-90, le=90)]
LonDeg = Annotated[float, Meta(ge=-180, le=180)]

HEADER_IDS = 2**32
"""After the highest number of a message comes 0 again, as in VDA 5050."""

Mode = Literal["auto", "manual", "paused", "stopped", "idle", "fault"]
Level = Literal["critical", "high", "medium", "low"]
NodeState = Literal["unknown", "stopped", "starting", "started", "stopping", "failure"]
OrderStatus = Literal["none", "loaded", "running", "paused", "done", "aborted", "failed"]


class Header(Struct, frozen=True, kw_only=True):
    """Fields every upward message carries."""

    v: Literal[1] = 1
    robot: Id
    boot: Annotated[str, Meta(min_length=8, max_length=64, description="new at each boot")]
    seq: Count
    mono_ms: Annotated[Count, Meta(description="robot monotonic clock since boot, ms")]
    wall_ms: Annotated[int, Meta(description="robot wall clock, ms since 1970; for people, not for rules")]
    header_id: (
        Annotated[
            int,
            Meta(ge=0, le=2**53, description="one more with each message of this kind; losses are counted by it"),
        ]
        | UnsetType
    ) = UNSET
