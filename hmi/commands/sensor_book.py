"""Stations of the farm as people keep them: accepted, named, calibrated, with limits. Every act is audited."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, replace

from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.ports import AuditSink
from hmi.commands.refusal import OrderRefused
from hmi.domain.role import Permission
from hmi.domain.sensors.calibration import MAX_GAIN, MIN_GAIN, Calibration
from hmi.domain.sensors.limit import SensorLimit, revision_of
from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.station import FieldStation
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.database import Database
from hmi.store.sensor_board import SensorBoard, StationNow
from hmi.store.sensor_stations import SensorStations


class SensorRefused(OrderRefused):
    """A wish that cannot be fulfilled; ``field`` is the input at fault."""

    def __init__(self, code: str, text: str, field: str = "") -> None:
        super().__init__(code, text)
        self.field = field


Cameras = Callable[[FieldStation, str], Awaitable[None]]


@dataclass(frozen=True, slots=True)
class SensorParts:
    """What the book is wired to.

    Attributes:
        parcel_of: id of the parcel that an id or a name means, ``None`` if there is none.
        on_camera: makes the pictures of an accepted camera station welcome; who accepted it.
        off_camera: forgets them.
    """

    board: SensorBoard
    stations: SensorStations
    database: Database
    authorize: Authorize
    audit: AuditSink
    clock: Clock
    parcel_of: Callable[[str], str | None]
    on_camera: Cameras
    off_camera: Cameras


@dataclass(frozen=True, slots=True)
class StationWish:
    """What a person wants of a station; ``None`` leaves it as it is."""

    name: str | None = None
    parcel: str | None = None
    lat_deg: float | None = None
    lon_deg: float | None = None


class SensorBook:
    """Answers people who manage stations.

    Raises (all methods): ``NotSignedIn``, ``NotAllowed``, ``StoreError`` and ``OrderRefused``.
    """

    def __init__(self, parts: SensorParts) -> None:
        self._parts = parts
        self._changing = asyncio.Lock()
        self._history: list[Calibration] = []

    def load(self, calibrations: Sequence[Calibration]) -> None:
        """Begin with every calibration there was, oldest first."""
        self._history = list(calibrations)

    def station(self, station_id: str) -> StationNow:
        """Return a station; raises ``OrderRefused`` where there is none."""
        known = self._parts.board.get(station_id)
        if known is None:
            raise OrderRefused("unknown_station", "There is no such station here. It has not announced itself.")
        return known

    async def accept(self, session: SessionInfo, station_id: str, wish: StationWish) -> FieldStation:
        """Take a station in: from now on it is recorded and counts; again it changes what is wished."""
        self._may(session)
        async with self._changing:
            known = self.station(station_id).station
            made = replace(
                self._wished(known, wish, is_new=not known.is_accepted), is_accepted=True,
                accepted_by=known.accepted_by or session.user_name,
                accepted_at=known.accepted_at or self._parts.clock.utc(),
            )  # fmt: skip
            await self._keep(made)
            if made.kind is SensorKind.CAMERA:
                await self._parts.on_camera(made, session.user_name)
        self._note(session, "accepted", f"Station {made.name} belongs to the farm.", station_id)
        return made

    async def change(
        self, session: SessionInfo, station_id: str, wish: StationWish, *, seen: str | None = None
    ) -> FieldStation:
        """Name or place an accepted station anew.

        Args:
            seen: revision of the station that the person looked at, ``None`` for whatever there is.
        """
        self._may(session)
        async with self._changing:
            before = self._accepted(station_id)
            if seen is not None and seen != before.revision:
                raise OrderRefused("changed_meanwhile", f"Somebody changed {before.name} meanwhile. Look again.")
            made = self._wished(before, wish)
            await self._keep(made)
        text = f"Station {before.name}: {made.name}, parcel {made.parcel or 'none'}."
        self._note(session, "changed", text, station_id)
        return made

    async def remove(self, session: SessionInfo, station_id: str) -> None:
        """Take a station out; what it measured stays until it is too old."""
        self._may(session)
        async with self._changing:
            known = self.station(station_id).station
            await self._parts.database.run(self._parts.stations.remove, station_id)
            self._history = [one for one in self._history if one.station_id != station_id]
            self._parts.board.remove(station_id)
            if known.kind is SensorKind.CAMERA and known.is_accepted:
                await self._parts.off_camera(known, session.user_name)
        self._note(session, "removed", f"Station {known.name} is taken out.", station_id)

    async def calibrate(self, session: SessionInfo, one: Calibration) -> Calibration:
        """Correct one channel from the next value on."""
        self._may(session)
        async with self._changing:
            known = self._accepted(one.station_id)
            if one.channel not in known.units:
                text = f"{known.name} does not measure {one.channel.label}."
                raise SensorRefused("unknown_quantity", text, "quantity")
            if not MIN_GAIN <= one.gain <= MAX_GAIN:
                text = f"The gain must lie between {MIN_GAIN:g} and {MAX_GAIN:g}."
                raise SensorRefused("bad_calibration", text, "gain")
            about = one.channel.about(known.units[one.channel])
            if abs(one.offset) > about.high - about.low:
                text = f"An offset of {about.text(one.offset)} is no calibration."
                raise SensorRefused("bad_calibration", text, "offset")
            made = replace(one, by=session.user_name, at=self._parts.clock.utc())
            await self._parts.database.run(self._parts.stations.add_calibration, made)
            self._history.append(made)
            self._parts.board.calibrate(made)
        text = f"{known.name}, {made.channel.label}: times {made.gain:g}, plus {made.offset:g}. {made.note}".strip()
        self._note(session, "calibrated", text, one.station_id)
        return made

    def calibrations(self, station_id: str) -> list[Calibration]:
        """Return every calibration of a station, newest first."""
        self.station(station_id)
        return [one for one in reversed(self._history) if one.station_id == station_id]

    async def set_limits(
        self, session: SessionInfo, limits: Sequence[SensorLimit], *, seen: str | None = None
    ) -> list[SensorLimit]:
        """Set all limits of the farm; those that did not change keep who set them.

        Args:
            seen: revision of the limits that the person looked at, ``None`` for whatever there is.
        """
        self._may(session)
        async with self._changing:
            if seen is not None and seen != revision_of(self._parts.board.limits):
                raise OrderRefused("changed_meanwhile", "Somebody changed the limits meanwhile. Look again.")
            before = {one.channel: one for one in self._parts.board.limits}
            made: list[SensorLimit] = []
            for number, one in enumerate(limits):
                if one.channel in {other.channel for other in made}:
                    text = f"{one.channel.label} has two limits. Keep one."
                    raise SensorRefused("bad_limit", text, f"limits.{number}.high")
                made.append(self._checked(session, one, before.get(one.channel), f"limits.{number}"))
            await self._parts.database.run(self._parts.stations.set_limits, made)
            self._parts.board.limits = made
        for one in made:
            if before.get(one.channel) != one:
                self._note(session, "limit", _words(one), one.channel.key)
        for channel in before.keys() - {one.channel for one in made}:
            self._note(session, "limit", f"{channel.label}: no limit any more.", channel.key)
        return made

    def _checked(self, session: SessionInfo, one: SensorLimit, before: SensorLimit | None, place: str) -> SensorLimit:
        about, label = one.channel.about(), one.channel.label
        for name, bound in (("low", one.low), ("high", one.high)):
            if bound is not None and not about.is_plausible(bound):
                raise SensorRefused("bad_limit", f"{label}: {about.text(bound)} never happens.", f"{place}.{name}")
        if one.low is None and one.high is None:
            raise SensorRefused("bad_limit", f"{label}: say the lowest or the highest value.", f"{place}.high")
        if one.low is not None and one.high is not None and one.low >= one.high:
            text = f"{label}: the lowest value must be below the highest."
            raise SensorRefused("bad_limit", text, f"{place}.low")
        if before is not None and replace(before, by="", at=None) == replace(one, by="", at=None):
            return before
        return replace(one, by=session.user_name, at=self._parts.clock.utc())

    def _accepted(self, station_id: str) -> FieldStation:
        known = self.station(station_id).station
        if not known.is_accepted:
            raise OrderRefused("not_accepted", f"{known.name} is new here. Accept it first.")
        return known

    def _wished(self, known: FieldStation, wish: StationWish, *, is_new: bool = False) -> FieldStation:
        """Return a station as wished; what a new one says of its parcel itself need not be known here."""
        parcel = known.parcel if wish.parcel is None else wish.parcel
        found = self._parts.parcel_of(parcel) if parcel else ""
        if found is None and wish.parcel is not None:
            raise SensorRefused("unknown_parcel", f"There is no parcel {parcel} on the map.", "parcel")
        return replace(
            known, name=known.name if wish.name is None else wish.name,
            parcel=(found or "") if is_new or wish.parcel is not None else known.parcel,
            lat_deg=known.lat_deg if wish.lat_deg is None else wish.lat_deg,
            lon_deg=known.lon_deg if wish.lon_deg is None else wish.lon_deg,
        )  # fmt: skip

    async def _keep(self, station: FieldStation) -> None:
        await self._parts.database.run(self._parts.stations.put, [station])
        known = self._parts.board.get(station.id)
        if known is not None:  # what it said meanwhile stays
            now = known.station
            station = replace(
                station, battery=now.battery, heard_at=now.heard_at, units=now.units, period_s=now.period_s,
                pictures_day=now.pictures_day, pictures=now.pictures,
            )  # fmt: skip
        self._parts.board.put(station)

    def _may(self, session: SessionInfo) -> None:
        self._parts.authorize(session, Permission.MANAGE_SENSORS)

    def _note(self, session: SessionInfo, outcome: str, text: str, ref: str) -> None:
        self._parts.audit.append(audit_line(session, "sensor", outcome, text, ref=ref))


def _words(one: SensorLimit) -> str:
    about = one.channel.about()
    low = "" if one.low is None else f"at least {about.text(one.low)}"
    high = "" if one.high is None else f"at most {about.text(one.high)}"
    bounds = " and ".join(part for part in (low, high) if part)
    kind = "treatment limit" if one.is_treatment else "limit"
    return f"{one.channel.label}: {kind} {bounds}. {one.note}".strip()
