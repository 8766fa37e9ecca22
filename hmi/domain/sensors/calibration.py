"""Calibration of one channel of one station: measured value times gain, plus offset, in the unit of the wire."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from hmi.domain.sensors.quantity import Channel

MIN_GAIN, MAX_GAIN = 0.1, 10.0  # beyond that the probe is broken, not off


@dataclass(frozen=True, slots=True)
class Calibration:
    """What is applied to values that come from now on; history stays as it was."""

    station_id: str
    channel: Channel
    offset: float = 0.0
    gain: float = 1.0
    note: str = ""
    by: str = ""
    at: datetime | None = None

    def apply(self, value: float) -> float:
        """Return the calibrated value."""
        return value * self.gain + self.offset
