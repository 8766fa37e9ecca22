"""What a station is told. Nothing of it moves a machine, and nothing of it is obeyed late."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Protocol


@dataclass(frozen=True, slots=True)
class NoticeOrder:
    """Treatment is under way near the station, or over, until ``until`` and never longer."""

    station_id: str
    ref: str
    at: datetime
    is_treating: bool
    robots: tuple[str, ...]
    parcel: str
    until: datetime


@dataclass(frozen=True, slots=True)
class TriggerOrder:
    """Take a picture now; the station refuses it when it is older than ``ttl_s``."""

    station_id: str
    ref: str
    at: datetime
    ttl_s: float


class StationSender(Protocol):
    """Speaks to stations; sends now or not at all."""

    @property
    def is_up(self) -> bool:
        """Whether what is sent now would leave."""
        ...

    def send(self, order: NoticeOrder | TriggerOrder) -> bool:
        """Send; False if there is no connection."""
        ...

    def clear_notice(self, station_id: str) -> bool:
        """Take the retained notice of a station away."""
        ...
