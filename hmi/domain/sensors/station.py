"""A station as it says it is, and as people of the farm know it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from datetime import datetime

from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.quantity import Channel

LOW_BATTERY = 0.15  # a station on solar power should be looked after within days
PICTURES_A_DAY = 100


@dataclass(frozen=True, slots=True)
class Announcement:
    """What a station says about itself, not trusted further than that; ``units`` by channel."""

    station_id: str
    name: str
    kind: SensorKind
    lat_deg: float
    lon_deg: float
    period_s: float
    units: dict[Channel, str] = field(default_factory=dict)
    model: str = ""
    parcel: str = ""


@dataclass(frozen=True, slots=True)
class FieldStation:
    """A station of the farm; ``is_accepted`` once somebody said that it belongs here.

    Args:
        units: of each channel it announced, as on the wire.
        heard_at: when anything of it was heard last.
        boot, seq: newest message.
        pictures_day, pictures: how many pictures it sent on that day (UTC, ``YYYY-MM-DD``).
    """

    id: str
    name: str
    kind: SensorKind
    lat_deg: float
    lon_deg: float
    period_s: float
    units: dict[Channel, str] = field(default_factory=dict)
    model: str = ""
    parcel: str = ""
    is_accepted: bool = False
    accepted_by: str = ""
    accepted_at: datetime | None = None
    battery: float | None = None
    heard_at: datetime | None = None
    pictures_day: str = ""
    pictures: int = 0

    @property
    def revision(self) -> str:
        """A mark that changes with what people keep of it: name, parcel and place."""
        kept = repr((self.name, self.parcel, self.lat_deg, self.lon_deg))
        return hashlib.sha256(kept.encode()).hexdigest()[:16]

    def pictures_on(self, day: str) -> int:
        """Return how many pictures it sent on a day."""
        return self.pictures if self.pictures_day == day else 0

    def announced(self, said: Announcement) -> FieldStation:
        """Return it after a new announcement: what people set stays."""
        changed = replace(self, kind=said.kind, period_s=said.period_s, units=said.units, model=said.model)
        if self.is_accepted:
            return changed
        return replace(changed, name=said.name, lat_deg=said.lat_deg, lon_deg=said.lon_deg, parcel=said.parcel)


def new_station(said: Announcement) -> FieldStation:
    """Return a station that nobody has accepted yet."""
    return FieldStation(
        said.station_id, said.name, said.kind, said.lat_deg, said.lon_deg, said.period_s, said.units, said.model,
        said.parcel,
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Report:
    """What a station measured at ``utc`` by its own clock; ``boot`` and ``seq`` name the message.

    ``mono_s`` is the same moment since its boot by a clock that is never set, ``None`` if it has none.
    """

    station_id: str
    boot: str
    seq: int
    utc: datetime
    values: tuple[tuple[Channel, float], ...] = ()
    battery: float | None = None
    mono_s: float | None = None


@dataclass(frozen=True, slots=True)
class StationAnswer:
    """How a station answered the notice or trigger ``ref``."""

    station_id: str
    ref: str
    is_accepted: bool
    text: str
