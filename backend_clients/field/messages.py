"""What a field station says and is told: the models of field sensor contract v1.

Depths in metres below ground, times in UTC (RFC 3339, ``Z``), values in the unit that ``about`` names for their
quantity. Stations have no challenge and no lease: nothing they are told moves a machine.
"""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from msgspec import UNSET, Meta, Struct, UnsetType

from backend_clients.edge.fields import Count, Id, LatDeg, LonDeg, Name, Share, Text

Ref = Annotated[str, Meta(min_length=8, max_length=64, description="UUID or the like; idempotency key")]
Utc = Annotated[datetime, Meta(tz=True, description="RFC 3339 in UTC, with Z")]
DepthM = Annotated[float, Meta(ge=0, le=20, description="metres below ground")]
Value = Annotated[float, Meta(ge=-1e9, le=1e9)]
Kind = Literal["weather", "soil", "respiration", "camera"]
Outcome = Literal["accepted", "rejected"]


class FromStation(Struct, frozen=True, kw_only=True):
    """Fields every upward message carries. Readers ignore fields they do not know."""

    station: Id
    v: Literal[1] = 1


class Quantity(Struct, frozen=True, kw_only=True):
    """One thing a station measures; the same quantity may come at several depths."""

    quantity: Id
    unit: Annotated[str, Meta(min_length=1, max_length=16)]
    depth_m: DepthM | UnsetType = UNSET


class About(FromStation, frozen=True, kw_only=True):
    """Retained: who the station is, where it stands, what it measures and how often.

    ``period_s`` is between two messages with data, of a camera between two pictures. A camera has no quantities.
    """

    name: Annotated[str, Meta(min_length=1, max_length=80)]
    kind: Kind
    lat_deg: LatDeg
    lon_deg: LonDeg
    period_s: Annotated[float, Meta(gt=0, le=86_400)]
    quantities: Annotated[list[Quantity], Meta(max_length=64)]
    model: Name = ""
    parcel: Name | UnsetType = UNSET


class Reading(Struct, frozen=True, kw_only=True):
    """One measured value."""

    quantity: Id
    value: Value
    depth_m: DepthM | UnsetType = UNSET


class Data(FromStation, frozen=True, kw_only=True):
    """What was measured at ``utc``. ``boot`` and ``seq`` name it: a repeat says nothing new.

    ``mono_ms`` is the station's own clock at ``utc``, which counts on while it sleeps and is never set: by it a clock
    that was set is told from a message that waited.
    ``battery`` is 0..1. ``notice`` is the treatment notice the station obeyed when it measured.
    A camera sends it without values, to say how its battery is.
    """

    boot: Annotated[str, Meta(min_length=8, max_length=64, description="new at each boot")]
    seq: Annotated[Count, Meta(description="rises by one a message within one boot")]
    utc: Utc
    values: Annotated[list[Reading], Meta(max_length=64)]
    mono_ms: Annotated[int, Meta(ge=0, le=2**53, description="since boot, asleep or awake")] | UnsetType = UNSET
    battery: Share | UnsetType = UNSET
    notice: Ref | UnsetType = UNSET


class Ack(FromStation, frozen=True, kw_only=True):
    """Answers one notice or trigger by its ``id``; ``text`` is a sentence for a person."""

    id: Ref
    outcome: Outcome
    text: Text


class ToStation(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Fields every downward message carries. Unknown fields are refused: a station must not guess."""

    station: Id
    v: Literal[1] = 1


class Notice(ToStation, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Retained: treatment is under way near the station (or over), until ``until_utc`` and never longer.

    ``robots`` are the robots that treat, ``parcel`` the parcel they treat, empty when it is over.
    """

    id: Ref
    utc: Utc
    is_treating: bool
    robots: Annotated[list[Id], Meta(max_length=64)]
    parcel: Name
    until_utc: Utc


class Trigger(ToStation, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Take a picture now; older than ``ttl_s`` it is refused. Never retained."""

    id: Ref
    utc: Utc
    ttl_s: Annotated[float, Meta(gt=0, le=60)]
