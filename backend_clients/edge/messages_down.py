"""What a robot is told: the downward half of edge contract v1.

Unknown fields are refused: a robot must not guess what a newer console meant.
Everything that can move a machine carries a lease token, a sequence within that lease, a time to live
and the challenge of the robot's newest heartbeat; none of it depends on two wall clocks agreeing.
"""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import UNSET, Meta, Struct, UnsetType, field

from backend_clients.edge.fields import Count, Id, LatDeg, LonDeg, Metres, Name, Positive, Text
from backend_clients.edge.machine import Point3
from backend_clients.edge.messages_up import Datum

Ref = Annotated[str, Meta(min_length=8, max_length=64, description="UUID or the like; idempotency key")]
Sha256 = Annotated[str, Meta(pattern="^[0-9a-f]{64}$")]
Challenge = Annotated[str, Meta(min_length=8, max_length=64, description="from the newest heartbeat")]
Action = Literal[
    "start",
    "resume",
    "pause",
    "abort",
    "return_home",
    "drive_open",
    "drive_close",
    "go_to",
    "tool_retract",
    "tool_go_to",
    "skip_target",
    "stock_refilled",
    "node_start",
    "node_stop",
    "node_restart",
]


class Order(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Fields every downward message carries."""

    v: Literal[1] = 1
    robot: Id


class Command(Order, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An instant action. ``pause``, ``abort`` and ``node_*`` need no lease (``lease_token`` 0).

    ``node`` names the node of ``node_*``; ``place`` is where ``go_to`` drives and ``tool_go_to`` moves the tool's tip:
    east and north are ENU metres of the factsheet's datum, the third is metres above the ground at that place. A
    ``go_to`` orders no height. ``target`` is the point that ``skip_target`` is about, for robots whose factsheet says
    ``skips_by_name``: one that works at another point refuses with ``other_target``.
    """

    command_id: Ref
    action: Action
    by: Name
    lease_token: Count = 0
    lease_seq: Count = 0
    ttl_ms: Annotated[int, Meta(ge=100, le=10_000)] = 2000
    challenge: Challenge
    mission_id: Id | None = None
    mission_sha256: Sha256 | None = None
    is_supervised: bool = True
    node: Id | UnsetType = UNSET
    place: Point3 | UnsetType = UNSET
    target: Id | UnsetType = UNSET


class Stop(Order, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Stop and latch. Valid at any age, in any order, from anyone; idempotent by ``stop_id``."""

    stop_id: Ref
    by: Name
    device: Name = ""
    reason: Name = ""


class StopReset(Order, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Clear latched presses; never moves anything. The robot stays paused."""

    reset_id: Ref
    stop_ids: Annotated[list[Ref], Meta(min_length=1, max_length=64)]
    by: Name
    reason: Annotated[str, Meta(min_length=1, max_length=200)]
    lease_token: Count
    lease_seq: Count
    ttl_ms: Annotated[int, Meta(ge=100, le=10_000)] = 2000
    challenge: Challenge


class Drive(Order, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """10 Hz, QoS 0. Missing for 0.5 s the robot stops by itself. The tool is off."""

    lease_token: Count
    lease_seq: Count
    challenge: Challenge
    v_mps: Annotated[float, Meta(ge=-2, le=2)]
    yaw_rate_radps: Annotated[float, Meta(ge=-2, le=2)]


class Jog(Order, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """10 Hz, QoS 0: joints moved by hand while driving by hand is open; rad/s or m/s by joint.

    The rules of ``Drive`` hold: missing for 0.5 s the joints stop; a soft limit slows, a limit stops.
    """

    lease_token: Count
    lease_seq: Count
    challenge: Challenge
    rates: Annotated[dict[Name, Annotated[float, Meta(ge=-2, le=2)]], Meta(min_length=1, max_length=16)]


class OperatorHeartbeat(Order, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """1 Hz while a page of the lease holder is open; sent only because a browser said so."""

    lease_token: Count
    lease_seq: Count
    challenge: Challenge


CONSOLE_NONCE = "console-"
"""How the nonces of the console's own pings begin; any other ping proves no console."""


class Ping(Order, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Asks the robot to echo ``nonce`` in its next heartbeat: measures the round trip.

    A nonce that begins with ``console-`` also says that the console lives; the STOP gateway's never do.
    """

    nonce: Annotated[str, Meta(min_length=1, max_length=64)]


class Segment(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One piece of path in the mission's ENU frame; ``points`` is (N, 2) metres, N >= 2.

    ``row`` counts from 1 for rows and is 0 elsewhere. The tool works only where ``tool_on``.
    Segments join end to start. Inside a segment the heading turns gently; where it jumps between two
    segments the later one says ``pivot``: stop, turn on the spot to its first direction, drive on.
    ``jump``: it begins where the robot stood when the rest was planned, not where the segment before ends;
    nothing drives from one to the other.
    ``backward``: its rear leads; only in a ``turn``, with the tool off, and only for a robot whose factsheet has
    ``path_reverse_mps``. Where it changes between two segments the robot stops and drives the other way: its heading
    goes on, the line turns back.
    ``dose`` is times the tool's usual one where the tool works; left out it is 1 and is no part of the hash.
    """

    kind: Literal["approach", "row", "turn", "headland", "exit"]
    points: Annotated[list[tuple[Metres, Metres]], Meta(min_length=2, max_length=100_000)]
    speed_mps: Annotated[float, Meta(gt=0, le=20)]
    tool_on: bool = False
    row: Count = 0
    pivot: bool = False
    jump: bool | UnsetType = UNSET
    backward: bool | UnsetType = UNSET
    dose: Annotated[float, Meta(ge=0, le=2)] | UnsetType = UNSET


class MapVersion(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The farm's published map that a mission was planned on."""

    number: Count
    sha256: Sha256


class Continues(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """This document goes on with another one of the same mission, as a VDA 5050 order update does.

    The first ``segments`` segments are the path that stays: those of the document ``base_sha256``, the last of
    them perhaps only its beginning. Where it ends is the stitch point; everything after it is new.
    """

    base_sha256: Sha256
    segments: Count


class Proof(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """That whoever redirects a robot that drives has control of it and decided just now; as in a command."""

    lease_token: Count
    lease_seq: Count
    challenge: Challenge
    ttl_ms: Annotated[int, Meta(ge=100, le=10_000)] = 2000


class Mission(Order, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A complete mission. Sending it moves nothing; the robot answers with the hash of what it stored.

    ``plant_spacing_m`` is for planters: one line of plants where the tool is on, one each so many metres along it; left
    out, the planter's usual density over ``width_m``, and no part of the hash.
    """

    mission_id: Id
    revision: Count
    name: Name
    field_name: Name
    datum: Datum
    width_m: Annotated[float, Meta(gt=0, le=100)]
    area_m2: Positive
    parcel: Annotated[
        list[list[tuple[LonDeg, LatDeg]]],
        Meta(min_length=1, max_length=200, description="rings, outer first, lon/lat as in GeoJSON"),
    ]
    segments: Annotated[list[Segment], Meta(min_length=1, max_length=20_000)]
    note: Text = ""
    at_end: Literal["stay", "return_home"] = "stay"
    home: tuple[Metres, Metres] | None = field(default=None)
    plant_spacing_m: Annotated[float, Meta(ge=0.05, le=100)] | UnsetType = UNSET
    map_version: MapVersion | UnsetType = UNSET
    continues: Continues | UnsetType = UNSET
    proof: Annotated[
        Proof | UnsetType, Meta(description="for an update while it runs; no part of the hash, nor of what is stored")
    ] = UNSET
