"""A recorded moment, as a page asks for it."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct, field

from backend_clients.edge.fields import Count, LatDeg, LonDeg, Metres, Name, Radians

MOST_UNDONE = 200


class Moment(Struct, frozen=True):
    """Where a robot was. What a robot may say of itself may be asked for again, so the limits are those of its wire.

    ``height_m`` is ``None`` and a joint is left out where the record does not tell it. ``undone`` are places that were
    worked at later, as far as the record tells; ``at_ms`` is the record's time, UTC.
    """

    lat_deg: LatDeg
    lon_deg: LonDeg
    theta_rad: Radians
    joints: dict[Name, float] = field(default_factory=dict)
    height_m: Metres | None = 0.0
    undone: Annotated[list[Name], Meta(max_length=MOST_UNDONE)] = field(default_factory=list)
    at_ms: Count | None = None
