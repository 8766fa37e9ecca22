"""What the console tells the media process: which robots belong to the farm, and what they work on."""

from __future__ import annotations

from msgspec import Struct, field

MAX_POINTS = 40_000


class FarmRobot(Struct, frozen=True):
    """A registered robot."""

    id: str
    name: str
    keep_out_m: float | None = None


class Farm(Struct, frozen=True):
    """The registered robots; others are not drawn, whatever they say."""

    robots: list[FarmRobot] = field(default_factory=list)


class Last(Struct, frozen=True):
    """Where a robot was when it was heard last: ENU metres of its datum, radians, seconds of the machine's own clock.

    ``joints_at_s`` is ``None`` where its joints were never heard; ``height_m`` is above the ground. A record tells
    ``lat_lon_deg``, which then counts in place of the metres.
    """

    x_m: float
    y_m: float
    theta_rad: float
    at_s: float
    joints: dict[str, float] = field(default_factory=dict)
    joints_at_s: float | None = None
    height_m: float = 0.0
    lat_lon_deg: tuple[float, float] | None = None


class Swath(Struct, frozen=True):
    """One piece of a mission's path: longitude, latitude pairs; ``row`` counts from 1, 0 is a way between rows."""

    points: list[tuple[float, float]]
    row: int = 0


class Treated(Struct, frozen=True):
    """A place that was worked at before the media process listened; ``at_ms`` is when, UTC, 0 where nobody knows."""

    id: str
    x_m: float
    y_m: float
    outcome: str
    at_ms: int = 0


class Plan(Struct, frozen=True):
    """What a robot works on: mission with its path, and the parcels around. Geometry is longitude, latitude."""

    mission_id: str = ""
    path: list[Swath] = field(default_factory=list)
    parcels: list[list[tuple[float, float]]] = field(default_factory=list)
    treated: list[Treated] = field(default_factory=list)
