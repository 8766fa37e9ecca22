"""Pictures that camera stations send by the broker: counted, and on to where field cameras' frames go."""

from __future__ import annotations

import asyncio
import logging
from dataclasses import replace
from typing import TYPE_CHECKING

from hmi.clock import Clock
from hmi.commands.field_frames import FrameRefused
from hmi.domain.camera_source import SourceRefused
from hmi.domain.picture import Moment
from hmi.domain.picture_header import BadPicture
from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.station import PICTURES_A_DAY, FieldStation
from hmi.store.database import Database
from hmi.store.errors import StoreError
from hmi.store.sensor_board import SensorBoard
from hmi.store.sensor_stations import SensorStations

if TYPE_CHECKING:
    from hmi.app.pictures import PictureDesk

LEAST_S = 5.0  # between two pictures of a camera that is triggered
log = logging.getLogger(__name__)


class SensorPictures:
    """Takes pictures of accepted camera stations, at most a hundred a day of each."""

    def __init__(
        self, board: SensorBoard, stations: SensorStations, desk: PictureDesk, database: Database, clock: Clock
    ) -> None:
        self._board, self._stations, self._desk, self._database, self._clock = board, stations, desk, database, clock
        self._taking: dict[str, asyncio.Task[None]] = {}
        self._following: set[asyncio.Task[None]] = set()
        desk.place_of = self.place_of
        self.counts = dict.fromkeys(("taken", "not_accepted", "too_many", "too_often", "bad", "not_kept", "busy"), 0)

    def take(self, station_id: str, jpeg: bytes) -> None:
        """Take a picture; on the event loop, does not wait."""
        known = self._board.get(station_id)
        if known is None or not known.station.is_accepted or known.station.kind is not SensorKind.CAMERA:
            self.counts["not_accepted"] += 1
        elif known.station.pictures_on(self._today()) >= PICTURES_A_DAY:
            self.counts["too_many"] += 1
        elif station_id in self._taking:
            self.counts["busy"] += 1
        else:
            task = asyncio.get_running_loop().create_task(self._take(station_id, jpeg), name="sensor-picture")
            self._taking[station_id] = task
            task.add_done_callback(lambda _task: self._taking.pop(station_id, None))

    def announced(self, station_id: str) -> None:
        """Follow what a station says of itself now; on the event loop, does not wait."""
        known = self._board.get(station_id)
        if known is None or not known.station.is_accepted or known.station.kind is not SensorKind.CAMERA:
            return
        task = asyncio.get_running_loop().create_task(self._follow(known.station), name="sensor-period")
        self._following.add(task)
        task.add_done_callback(self._following.discard)

    async def welcome(self, station: FieldStation, by: str) -> None:
        """Let an accepted station send its pictures; too many cameras are told in the log."""
        try:
            await self._desk.sources.welcome(station.id, station.name, by, max(LEAST_S, station.period_s))
        except SourceRefused as error:
            log.warning("pictures of %s are not taken: %s", station.id, error.text)

    async def welcome_new(self, station: FieldStation) -> None:
        """Let a station of the demo send its pictures."""
        if station.kind is SensorKind.CAMERA:
            await self.welcome(station, station.accepted_by)

    async def dismiss(self, station: FieldStation, _by: str) -> None:
        """Forget the camera of a station that was taken out."""
        await self._desk.sources.dismiss(station.id)

    async def start(self) -> None:
        """Expect pictures as often as accepted stations say; raises ``StoreError``."""
        for known in self._board.accepted():
            if known.station.kind is SensorKind.CAMERA:
                await self._expect(known.station)

    def place_of(self, camera: str) -> Moment:
        """Return where a field camera stands, if it is a station of the farm."""
        known = self._board.get(camera)
        is_ours = known is not None and known.station.is_accepted
        return Moment(known.station.lat_deg, known.station.lon_deg) if known is not None and is_ours else Moment()

    async def stop(self) -> None:
        """Finish what is being taken."""
        await asyncio.gather(*self._taking.values(), *self._following, return_exceptions=True)

    async def _take(self, station_id: str, jpeg: bytes) -> None:
        try:
            one = self._desk.frames.admit_station(station_id, LEAST_S)
            await self._desk.frames.take(one, jpeg, None, self.place_of(station_id))
        except FrameRefused as error:
            self.counts["too_often" if error.code == "too_often" else "not_accepted"] += 1
            return
        except BadPicture as error:
            log.info("a picture of %s cannot be used: %s", station_id, error)
            self.counts["bad"] += 1
            return
        except StoreError as error:
            log.warning("a picture of %s was not kept: %s", station_id, error)
            self.counts["not_kept"] += 1
            return
        self.counts["taken"] += 1
        await self._count(station_id)

    async def _count(self, station_id: str) -> None:
        known, day = self._board.get(station_id), self._today()
        if known is None or not known.station.is_accepted:
            return
        made = replace(known.station, pictures_day=day, pictures=known.station.pictures_on(day) + 1)
        self._board.put(made)
        await self._expect(made)
        try:
            await self._database.run(self._stations.note, [made])
        except StoreError as error:
            log.warning("the pictures of %s today are counted in memory only: %s", station_id, error)

    async def _expect(self, station: FieldStation) -> None:
        """A camera is expected as often as its station says now, whatever it said when it was welcomed."""
        await self._desk.sources.expect(station.id, max(LEAST_S, station.period_s))

    async def _follow(self, station: FieldStation) -> None:
        try:
            await self._expect(station)
        except StoreError as error:
            log.warning("pictures of %s are expected as before: %s", station.id, error)

    def _today(self) -> str:
        return self._clock.utc().date().isoformat()
