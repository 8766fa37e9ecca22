"""Stations as screens show them: values in people's units, ages, sentences; see docs/protocols/rest.md."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from hmi.clock import Clock
from hmi.commands.treatment_notice import Notice
from hmi.domain.role import Permission
from hmi.domain.sensors.calibration import Calibration
from hmi.domain.sensors.freshness import State, state_of
from hmi.domain.sensors.gate import Gate
from hmi.domain.sensors.limit import SensorLimit, revision_of
from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.quantity import Channel
from hmi.domain.sensors.series import Point, Span, stepped, with_gaps
from hmi.domain.sensors.station import LOW_BATTERY, PICTURES_A_DAY
from hmi.presenters.units import percent
from hmi.security.authorization import Authorize, is_allowed
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.sensor_board import SensorBoard, StationNow, ValueNow, is_recent
from hmi.store.sensor_history import SensorHistory

Row = dict[str, Any]
Treated = tuple[datetime, datetime | None, str]


@dataclass(frozen=True, slots=True)
class SensorViewParts:
    """What is shown, and where it comes from.

    Args:
        parcel_name: what people call a parcel, empty if it is not on the map.
        notice_of: what a station was told.
        treated: treatments of a parcel since a time, oldest first.
        forecast: the forecast as it is shown, ``None`` if there is none.
    """

    board: SensorBoard
    history: SensorHistory
    database: Database
    clock: Clock
    authorize: Authorize
    parcel_name: Callable[[str], str]
    notice_of: Callable[[str], Notice | None]
    gate: Callable[[], Gate]
    treated: Callable[[str, datetime], Awaitable[Sequence[Treated]]]
    forecast: Callable[[], Row | None]


class SensorView:
    """Reads everything about stations for one person."""

    def __init__(self, parts: SensorViewParts) -> None:
        self._parts = parts

    def whole(self, session: SessionInfo) -> Row:
        """Return every station, the gate and what this person may do."""
        parts = self._parts
        gate = parts.gate()
        return {
            "stations": [self._station(one) for one in parts.board.all()],
            "gate": {
                "state": gate.state.value,
                "sentence": gate.sentence,
                "facts": [{"label": one.label, "text": one.text, "ok": one.is_ok} for one in gate.facts],
            },
            "forecast": parts.forecast(),
            "now_utc": _utc(parts.clock.utc()),
            "can": {
                "accept": self._can(session, Permission.MANAGE_SENSORS),
                "limits": self._can(session, Permission.MANAGE_SENSORS),
                "calibrate": self._can(session, Permission.MANAGE_SENSORS),
                "trigger": self._can(session, Permission.TRIGGER_SENSOR),
            },
        }

    def station(self, known: StationNow) -> Row:
        """Return one station."""
        return self._station(known)

    def limits(self) -> list[Row]:
        """Return the farm's limits in the units of screens."""
        ordered = sorted(self._parts.board.limits, key=lambda one: one.channel.order)
        revision = revision_of(ordered)  # in each row, since a list has no place of its own for it; none has none
        return [{**_limit_row(one), "revision": revision} for one in ordered]

    def calibrations(self, found: Sequence[Calibration]) -> list[Row]:
        """Return calibrations; the offset in the unit of screens."""
        return [
            {
                "quantity": one.channel.quantity, "depth_m": one.channel.depth_m, "label": one.channel.label,
                "offset": round(one.offset * one.channel.about().factor, 6), "gain": one.gain,
                "unit": one.channel.about().shown_unit, "note": one.note, "by": one.by,
                "at": None if one.at is None else _utc(one.at),
            }
            for one in found
        ]  # fmt: skip

    async def series(self, known: StationNow, channel: Channel, span: Span) -> Row:
        """Return a channel over time, in steps, with gaps where nothing was measured."""
        parts, now = self._parts, self._parts.clock.utc()
        about = channel.about(known.station.units.get(channel, ""))
        step_s, since = span.step_s(known.station.period_s), now - span.length
        found = await parts.database.run(parts.history.points, known.station.id, channel, since)
        steps = stepped(channel.quantity, found, step_s)
        digits, factor = about.digits + 1, about.factor

        def row(at: datetime, one: Point | None) -> list[Any]:
            if one is None:
                return [_utc(at), None, None, None]
            return [_utc(at), *(round(value * factor, digits) for value in (one.mean, one.low, one.high))]

        limit = parts.board.limit(channel)
        treated = await parts.treated(known.station.parcel, since) if known.station.parcel else ()
        return {
            "unit": about.shown_unit,
            "step_s": step_s,
            "points": [row(at, one) for at, one in with_gaps(steps, step_s, now)],
            "limits": _bounds(limit) or {"low": None, "high": None},
            "treatments": [
                {"from_utc": _utc(begin), "to_utc": None if end is None else _utc(end), "text": text}
                for begin, end, text in treated
            ],
        }

    def _station(self, known: StationNow) -> Row:
        parts, station, now_s = self._parts, known.station, self._parts.clock.mono_s()
        age_s, state = known.age_s(now_s), known.state(now_s)
        is_low = station.battery is not None and station.battery <= LOW_BATTERY
        day = parts.clock.utc().date().isoformat()
        is_camera = station.kind is SensorKind.CAMERA
        return {
            "id": station.id,
            "name": station.name,
            "revision": station.revision,
            "kind": station.kind.value,
            "parcel": station.parcel or None,
            "parcel_name": parts.parcel_name(station.parcel) if station.parcel else "",
            "lat_deg": station.lat_deg,
            "lon_deg": station.lon_deg,
            "is_accepted": station.is_accepted,
            "period_s": station.period_s,
            "model": station.model,
            "state": state.value,
            "age_s": None if age_s is None else round(age_s, 1),
            "heard_utc": None if station.heard_at is None else _utc(station.heard_at),
            "battery": station.battery,
            "battery_low": is_low,
            "sentence": sentence(known, now_s),
            "values": [self._value(one, known, now_s) for one in known.ordered()],
            "notice": _notice_row(parts.notice_of(station.id)),
            "camera": station.id if is_camera and station.is_accepted else None,
            "pictures_today": station.pictures_on(day) if is_camera else 0,
            "pictures_limit": PICTURES_A_DAY if is_camera else 0,
        }

    def _value(self, one: ValueNow, known: StationNow, now_s: float) -> Row:
        channel = one.channel
        about = channel.about(known.station.units.get(channel, ""))
        limit, age_s = self._parts.board.limit(channel), max(0.0, now_s - one.measured_s)
        return {
            "key": channel.key,
            "quantity": channel.quantity,
            "label": channel.label,
            "unit": about.shown_unit,
            "depth_m": channel.depth_m,
            "value": about.shown(one.value),
            "age_s": round(age_s, 1),
            "state": state_of(age_s, known.station.period_s).value,
            "is_plausible": one.is_plausible,
            "limit": None if limit is None else {**(_bounds(limit) or {}), "is_treatment": limit.is_treatment},
            "is_over": limit is not None and one.is_plausible and limit.is_over(one.value),
            "trend": one.trend(),
        }

    def _can(self, session: SessionInfo, permission: Permission) -> bool:
        return not is_allowed(self._parts.authorize, session, permission, None)


def sentence(known: StationNow, now_s: float) -> str:
    """Return what is wrong with a station in a sentence or two, empty if nothing is."""
    station, state, age_s = known.station, known.state(now_s), known.age_s(now_s)
    parts = []
    if state is State.NEVER:
        parts.append(f"{station.name} has not measured anything yet.")
    elif state is State.SILENT and age_s is not None:
        last = "" if station.battery is None else f" Battery {percent(station.battery)} % when last heard."
        parts.append(f"{station.name} silent for {long_age(age_s)}.{last}")
    elif state is State.LATE and age_s is not None:
        parts.append(f"Late: the last values are {long_age(age_s)} old.")
    is_heard = state in (State.FRESH, State.LATE)
    if is_heard and station.battery is not None and station.battery <= LOW_BATTERY:
        parts.append(f"Battery {percent(station.battery)} %.")
    if known.receipt.is_clock_wrong:
        parts.append(clock_words(known.receipt.skew_s))
    is_behind = known.receipt.is_clock_wrong and known.receipt.skew_s < 0
    if is_heard and not is_behind and any(not one.is_dated for one in known.values.values()):
        parts.append("Its clock was set, or its values waited: they count from the next ones on.")
    wrong = [one for one in known.ordered() if not one.is_plausible and is_heard and is_recent(known, one, now_s)]
    if wrong:
        about = wrong[0].channel.about(station.units.get(wrong[0].channel, ""))
        parts.append(f"{wrong[0].channel.label} {about.text(wrong[0].value)} cannot be true.")
    if not station.is_accepted:
        parts.append("New here: it is not recorded before it is accepted.")
    return " ".join(parts)


def clock_words(skew_s: float) -> str:
    """Return what a wrong clock means."""
    if skew_s > 0:
        return f"Its clock is {long_age(skew_s)} ahead."
    return f"Its clock is {long_age(-skew_s)} behind, or its values come so late: they count as old."


def long_age(age_s: float) -> str:
    """Return an age in one unit: ``40 s``, ``12 min``, ``6 h``, ``3 days``."""
    for size_s, unit in ((86_400, "days"), (3600, "h"), (60, "min")):
        if age_s >= 2 * size_s:
            return f"{age_s // size_s:.0f} {unit}"
    return f"{age_s:.0f} s"


def _notice_row(notice: Notice | None) -> Row | None:
    if notice is None:
        return None
    return {"state": notice.state.value, "text": notice.text, "since_utc": _utc(notice.since)}


def _bounds(limit: SensorLimit | None) -> Row | None:
    if limit is None:
        return None
    factor = limit.channel.about().factor
    low, high = (None if bound is None else round(bound * factor, 6) for bound in (limit.low, limit.high))
    return {"low": low, "high": high}


def _limit_row(one: SensorLimit) -> Row:
    return {
        "quantity": one.channel.quantity,
        "depth_m": one.channel.depth_m,
        "label": one.channel.label,
        "unit": one.channel.about().shown_unit,
        **(_bounds(one) or {}),
        "is_treatment": one.is_treatment,
        "note": one.note,
        "by": one.by,
        "at": None if one.at is None else _utc(one.at),
    }


def _utc(at: datetime) -> str:
    return at.isoformat(timespec="milliseconds").replace("+00:00", "Z")
