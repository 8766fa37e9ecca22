"""The stations as they are now, in memory: who they are, what they said last and how old that is.

Belongs to the event loop. What is measured by accepted stations goes on to the history.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta

from hmi.clock import Clock
from hmi.domain.sensors.calibration import Calibration
from hmi.domain.sensors.freshness import (
    CLOCK_WRONG_S,
    LATE_PERIODS,
    Arrival,
    Fate,
    Receipt,
    State,
    is_usable,
    state_of,
)
from hmi.domain.sensors.gate import Measured
from hmi.domain.sensors.limit import SensorLimit, limit_for
from hmi.domain.sensors.quantity import Channel
from hmi.domain.sensors.station import Announcement, FieldStation, Report, new_station

MOST_STATIONS = 200  # accepted and not: names on a broker cost nothing to invent
TREND_S, TREND_LEAST_S, TREND_STEP_S = 7200.0, 3000.0, 540.0
COUNTED = ("repeated", "late", "too_old", "implausible", "unannounced", "unknown", "too_many")
Keep = Callable[[str, Channel, datetime, float], None]


@dataclass(slots=True)
class ValueNow:
    """The newest value of a channel, calibrated, in the unit of the wire.

    Args:
        measured_s: when, on the console's monotonic clock; see ``freshness``.
        is_plausible: whether nature can do this.
        is_kept: out of the history, from before this machine was switched on: nobody knows for how long it was off.
        is_dated: its age is known, and nothing newer came whose age is not.
        trail: a value each ten minutes of the last hours, oldest first.
    """

    channel: Channel
    value: float
    measured_s: float
    measured_at: datetime
    is_plausible: bool = True
    is_kept: bool = False
    is_dated: bool = True
    trail: deque[tuple[float, float]] = field(default_factory=deque)

    def trend(self) -> str | None:
        """Return ``up``, ``down`` or ``steady``; ``None`` while too little is known."""
        if not self.trail or self.measured_s - self.trail[0][0] < TREND_LEAST_S:
            return None
        change = self.value - self.trail[0][1]
        steady = self.channel.about().steady
        return "steady" if abs(change) <= steady else "up" if change > 0 else "down"

    def take(self, value: float, arrival: Arrival) -> None:
        """Take a newer value."""
        self.put(value, arrival)
        if not self.trail or arrival.measured_s - self.trail[-1][0] >= TREND_STEP_S:
            self.trail.append((arrival.measured_s, value))
        while self.trail and arrival.measured_s - self.trail[0][0] > TREND_S:
            self.trail.popleft()

    def put(self, value: float, arrival: Arrival) -> None:
        """Take a newer value that is no part of the trail."""
        self.value, self.measured_s, self.measured_at = value, arrival.measured_s, arrival.measured_at
        self.is_kept, self.is_dated = False, arrival.is_dated


@dataclass(slots=True)
class StationNow:
    """One station now."""

    station: FieldStation
    receipt: Receipt = field(default_factory=Receipt)
    values: dict[Channel, ValueNow] = field(default_factory=dict)

    def age_s(self, now_s: float) -> float | None:
        """Return the age of what it measured last, ``None`` if nothing is known."""
        newest_s = self.receipt.newest_s
        return None if newest_s == float("-inf") else max(0.0, now_s - newest_s)

    def state(self, now_s: float) -> State:
        """Return how far it can be relied on."""
        return state_of(self.age_s(now_s), self.station.period_s)

    def measures(self, channel: Channel) -> bool:
        """Say whether it announces a channel; what it announces may not be known yet, and then it may."""
        return not self.station.units or channel in self.station.units

    def ordered(self) -> list[ValueNow]:
        """Return its values as people look at them."""
        return sorted(self.values.values(), key=lambda one: one.channel.order)


def _is_behind(now: datetime, kept: Iterable[datetime]) -> bool:
    """Say whether something was measured in the future: then no age of what is kept is known, nor whether it is old."""
    return any((at - now).total_seconds() > CLOCK_WRONG_S for at in kept)


def usable(known: StationNow, value: ValueNow, now_s: float) -> bool:
    """Say whether a decision may still go by a value of a station."""
    if value.is_kept or not value.is_dated:
        return False
    age_s, is_slow = now_s - value.measured_s, value.channel.about().is_slow
    return is_usable(age_s, known.station.period_s, is_slow=is_slow)


def is_recent(known: StationNow, value: ValueNow, now_s: float) -> bool:
    """Say whether a value is one of those that its station measures now, and not left over from before."""
    return state_of(now_s - value.measured_s, known.station.period_s) is not State.SILENT


class SensorBoard:
    """Every station of one console.

    Args:
        keep: takes each value of an accepted station for the history.
    """

    def __init__(self, clock: Clock, keep: Keep) -> None:
        self._clock, self._keep = clock, keep
        self._stations: dict[str, StationNow] = {}
        self._calibrations: dict[tuple[str, Channel], Calibration] = {}
        self.limits: list[SensorLimit] = []
        self.counts = dict.fromkeys(
            ("repeated", "late", "too_old", "implausible", "unannounced", "unknown", "too_many"), 0
        )
        self.on_changed: list[Callable[[str], None]] = []
        self.on_report: list[Callable[[StationNow], None]] = []

    # ---- what is kept ----

    def load(
        self,
        stations: Iterable[FieldStation],
        calibrations: Iterable[Calibration],
        limits: Sequence[SensorLimit],
        newest: Iterable[tuple[str, Channel, datetime, float]],
        since: datetime | None = None,
    ) -> None:
        """Begin with what is kept; what was measured before shows its true age, nothing where that is not known.

        Args:
            since: what was measured later was since this machine was switched on; see ``fill``.
        """
        for one in stations:
            self._stations[one.id] = StationNow(one)
        for calibration in calibrations:  # oldest first: the newest counts
            self._calibrations[calibration.station_id, calibration.channel] = calibration
        self.limits = list(limits)
        now, now_s = self._clock.utc(), self._clock.mono_s()
        kept = self._of_ours(newest)
        heard = [one.station.heard_at for one in self._stations.values() if one.station.heard_at is not None]
        if _is_behind(now, [*heard, *(row[2] for row in kept)]):
            for known in self._stations.values():
                if known.station.heard_at is not None:  # late now, and silent if it does not speak
                    known.receipt.newest_s = now_s - LATE_PERIODS * known.station.period_s - 1.0
            return
        self.fill(kept, since)
        for known in self._stations.values():
            if known.station.heard_at is not None:
                heard_s = now_s - max(0.0, (now - known.station.heard_at).total_seconds())
                known.receipt.newest_s = max(known.receipt.newest_s, heard_s)

    def fill(self, newest: Iterable[tuple[str, Channel, datetime, float]], since: datetime | None = None) -> None:
        """Take values out of the history where nothing was heard yet; nothing while the clock is behind it.

        Args:
            since: only what was measured later is good for a decision: a clock without a battery stands while the
                machine is off. ``None``: nothing is.
        """
        now, now_s = self._clock.utc(), self._clock.mono_s()
        kept = self._of_ours(newest)
        if _is_behind(now, (row[2] for row in kept)):
            return
        for station_id, channel, at, value in kept:
            known = self._stations[station_id]
            if channel in known.values or not known.measures(channel):
                continue
            measured_s = now_s - max(0.0, (now - at).total_seconds())
            is_plausible, is_kept = channel.about().is_plausible(value), since is None or at <= since
            known.values[channel] = ValueNow(channel, value, measured_s, at, is_plausible, is_kept)
            known.receipt.newest_s = max(known.receipt.newest_s, measured_s)
            self._tell(station_id)

    def _of_ours(
        self, rows: Iterable[tuple[str, Channel, datetime, float]]
    ) -> list[tuple[str, Channel, datetime, float]]:
        """Leave out stations that are not there: their times say nothing about anything that is shown."""
        return [row for row in rows if row[0] in self._stations]

    # ---- what is asked ----

    def all(self) -> list[StationNow]:
        """Return every station, accepted ones first, by name."""
        return sorted(self._stations.values(), key=lambda one: (not one.station.is_accepted, one.station.name))

    def accepted(self) -> list[StationNow]:
        """Return the stations that belong to the farm."""
        return [one for one in self._stations.values() if one.station.is_accepted]

    def get(self, station_id: str) -> StationNow | None:
        """Return one station."""
        return self._stations.get(station_id)

    def calibration(self, station_id: str, channel: Channel) -> Calibration | None:
        """Return the calibration that counts now."""
        return self._calibrations.get((station_id, channel))

    def limit(self, channel: Channel) -> SensorLimit | None:
        """Return the limit of a channel."""
        return limit_for(self.limits, channel)

    def measured(self) -> list[Measured]:
        """Return the newest values of accepted stations, as the gate judges them."""
        now_s = self._clock.mono_s()
        return [
            Measured(one.channel, one.value,
                     one.is_plausible and usable(known, one, now_s), known.station.id)
            for known in self.accepted() for one in known.values.values()
        ]  # fmt: skip

    # ---- what changes ----

    def announced(self, said: Announcement) -> None:
        """Take what a station says about itself."""
        known = self._stations.get(said.station_id)
        if known is None:
            if len(self._stations) >= MOST_STATIONS:
                self.counts["too_many"] += 1
                return
            self._stations[said.station_id] = StationNow(new_station(said))
            self._tell(said.station_id)
            return
        changed = known.station.announced(said)
        if changed != known.station:
            known.station = changed
            known.values = {key: one for key, one in known.values.items() if key in said.units}
            self._tell(said.station_id)

    def gone(self, station_id: str) -> None:
        """Forget a station that took its announcement back and was never accepted."""
        known = self._stations.get(station_id)
        if known is not None and not known.station.is_accepted:
            del self._stations[station_id]
            self._tell(station_id)

    def reported(self, report: Report, received_s: float) -> None:
        """Take values; ``received_s`` is when they arrived, on the monotonic clock."""
        known = self._stations.get(report.station_id)
        if known is None:
            self.counts["unknown"] += 1  # its announcement is retained: it comes first, or soon
            return
        before = known.state(self._clock.mono_s())
        waited_s = max(0.0, self._clock.mono_s() - received_s)
        now = self._clock.utc() - timedelta(seconds=waited_s)
        arrival = known.receipt.judge(
            report.boot,
            report.seq,
            report.utc,
            now=now,
            now_s=received_s,
            period_s=known.station.period_s,
            mono_s=report.mono_s,
        )
        if arrival.is_ahead and arrival.fate is not Fate.NEWEST:
            self._doubt(known, report)
        if arrival.fate in (Fate.REPEATED, Fate.TOO_OLD):
            self.counts[arrival.fate.value] += 1
            return
        if arrival.fate is Fate.HISTORY:
            self.counts["late"] += 1
        else:
            battery = known.station.battery if report.battery is None else report.battery
            known.station = replace(known.station, battery=battery, heard_at=arrival.measured_at)
        for channel, raw in report.values:
            self._value(known, channel, raw, arrival)
        if before is not known.state(self._clock.mono_s()):
            self._tell(report.station_id)
        if arrival.fate is Fate.NEWEST:
            for listener in self.on_report:
                listener(known)

    def put(self, station: FieldStation) -> None:
        """Replace what is known of a station."""
        known = self._stations.get(station.id)
        if known is None:
            self._stations[station.id] = StationNow(station)
        else:
            known.station = station
        self._tell(station.id)

    def remove(self, station_id: str) -> None:
        """Take a station out; one that is still heard is a new one from now on."""
        known = self._stations.pop(station_id, None)
        if known is not None and known.state(self._clock.mono_s()) in (State.FRESH, State.LATE):
            station = replace(known.station, is_accepted=False, accepted_by="", accepted_at=None)
            self._stations[station_id] = StationNow(station, known.receipt, known.values)
        self._calibrations = {key: one for key, one in self._calibrations.items() if key[0] != station_id}
        self._tell(station_id)

    def calibrate(self, one: Calibration) -> None:
        """Use a calibration from the next value on; what was measured before is no trend to that."""
        self._calibrations[one.station_id, one.channel] = one
        known = self._stations.get(one.station_id)
        if known is not None and one.channel in known.values:
            known.values[one.channel].trail.clear()

    def _doubt(self, known: StationNow, report: Report) -> None:
        """Let no decision go by what came before: newer is known to be there, though not since when."""
        for channel, _ in report.values:
            if channel in known.values:
                known.values[channel].is_dated = False
        for listener in self.on_report:
            listener(known)

    def _value(self, known: StationNow, channel: Channel, raw: float, arrival: Arrival) -> None:
        station = known.station
        if channel not in station.units:  # nobody knows in which unit this is
            self.counts["unannounced"] += 1
            return
        calibration = self._calibrations.get((station.id, channel))
        value = raw if calibration is None else calibration.apply(raw)
        is_plausible = channel.about().is_plausible(value)
        if not is_plausible:
            self.counts["implausible"] += 1
        elif station.is_accepted:
            self._keep(station.id, channel, arrival.measured_at, value)
        if arrival.fate is not Fate.NEWEST:
            return
        shown = known.values.get(channel)
        if shown is None:
            shown = known.values[channel] = ValueNow(channel, value, arrival.measured_s, arrival.measured_at)
        shown.is_plausible = is_plausible
        if is_plausible:
            shown.take(value, arrival)
        else:
            shown.put(value, arrival)

    def _tell(self, station_id: str) -> None:
        for listener in self.on_changed:
            listener(station_id)
