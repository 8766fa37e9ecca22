"""What serves field sensors, plugged together; loaded by ``hmi.app.sensors``."""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hmi.api.sensor_view import SensorView, SensorViewParts
from hmi.api.sensors import SensorServices
from hmi.app.sensor_pictures import SensorPictures
from hmi.app.sensor_treatment import TreatmentWatch
from hmi.app.sensor_weather import feed_weather
from hmi.app.sensors import SensorWiring
from hmi.commands.sensor_book import SensorBook, SensorParts
from hmi.commands.sensor_trigger import SensorTrigger
from hmi.commands.treatment_notice import NoticeState, TreatmentNotices
from hmi.domain.alarm.finding import Findings
from hmi.domain.sensors.condition import StationCondition
from hmi.domain.sensors.gate import Gate, gate
from hmi.domain.sensors.station import Announcement, StationAnswer
from hmi.ingest.field import FieldCoordinator, FieldListeners, field_link
from hmi.ingest.supervision.stations import AtWork, condition_of, source_of, station_findings, work_findings
from hmi.planning.side_process import SideProcess
from hmi.store.errors import StoreError
from hmi.store.machine_boot import measured_since
from hmi.store.sensor_board import SensorBoard, StationNow
from hmi.store.sensor_history import SensorHistory
from hmi.store.sensor_stations import SensorStations

ROUND_S = 5.0
THIN_S = 1800.0
KEEP_S = 600.0  # how often battery and last sign of life are written
NEWS_S = 1.0
BOOT_FILE = Path("run") / "boot.json"
log = logging.getLogger(__name__)


class SensorWork:
    """Board, connection, history, book, notices and view of one farm."""

    def __init__(self, wiring: SensorWiring, forecast: Callable[[], dict[str, Any] | None]) -> None:
        self._wiring = wiring
        settings, clock, records, farm = wiring.settings, wiring.clock, wiring.records, wiring.settings.farm_id
        self.history = SensorHistory(records.database, farm)
        self.stations = SensorStations(records.database, farm)
        self.board = SensorBoard(clock, self.history.see)
        self.treatment = TreatmentWatch(wiring.fleet, records.missions, records.features, records.database, farm)
        self.pictures = SensorPictures(self.board, self.stations, wiring.pictures, records.database, clock)
        ca_file = str(settings.broker_ca) if settings.broker_ca else None
        link = wiring.make_link or field_link(
            settings.broker_url, f"headland-field-{secrets.token_hex(6)}", ca_file=ca_file
        )
        self.link = FieldCoordinator(link, clock, self._listeners())
        self.trigger = SensorTrigger(self.link, clock, wiring.authorize, records.audit)
        self.notices = TreatmentNotices(
            self.link, clock, lambda: [one.station for one in self.board.accepted()], self._changed
        )
        self.book = SensorBook(
            SensorParts(
                self.board, self.stations, records.database, wiring.authorize, records.audit, clock,
                self.treatment.parcel_of, self.pictures.welcome, self.pictures.dismiss,
            )
        )  # fmt: skip
        self.view = self._make_view(forecast)
        self.board.on_changed.append(self._changed)
        self.board.on_report.append(lambda _known: feed_weather(self.board, wiring.weather, clock))
        self._at_work: list[AtWork] = []
        self._states: dict[str, Any] = {}
        self._tasks: list[asyncio.Task[None]] = []
        self._is_news_due = False

    # ---- life ----

    async def start(self) -> None:
        """Read what is kept and begin to listen; raises ``StoreError``."""
        run = self._wiring.records.database.run
        await self.treatment.load()
        is_new = await self._seed()
        calibrations = await run(self.stations.calibrations)
        stations, limits = await run(self.stations.all), await run(self.stations.limits)
        newest, path, now = (
            await run(self.history.newest),
            self._wiring.settings.data / BOOT_FILE,
            self._wiring.clock.utc(),
        )
        kept = [row[2] for row in newest]
        since = await asyncio.to_thread(measured_since, path, kept, now)
        self.board.load(stations, calibrations, limits, newest, since)
        self.book.load(calibrations)
        await self.pictures.start()
        self.history.start()
        await self.link.start()
        self._tasks = [
            asyncio.create_task(self._every(ROUND_S, self.round), name="sensors-round"),
            asyncio.create_task(self._every(KEEP_S, self._keep), name="sensors-keep"),
            asyncio.create_task(self._every(THIN_S, self._thin), name="sensors-thin"),
        ]
        if is_new:
            self._tasks.append(asyncio.create_task(self._past(), name="sensors-past"))

    async def stop(self) -> None:
        """End; what waits is written."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await self.link.stop()
        await self.pictures.stop()
        try:
            await self._keep()
        except StoreError as error:
            log.warning("the last sign of life of stations was not kept: %s", error)
        await asyncio.to_thread(self.history.close)

    # ---- what others ask ----

    def services(self) -> SensorServices:
        """Return what the routes need."""
        return SensorServices(self.view, self.book, self.trigger)

    def gate(self) -> Gate:
        """Judge treatment now."""
        return gate(self.board.limits, self.board.measured())

    def findings(self) -> dict[str, tuple[str, Findings]]:
        """Return what is wrong, by source."""
        now_s = self._wiring.clock.mono_s()
        found = dict(station_findings(self.board, now_s, self._notice_troubles()))
        if self._at_work:
            for source, findings in work_findings(self.board, self.gate(), self._at_work, now_s).items():
                found[source] = (*found.get(source, ()), *findings)
        names = {source_of(one.station.id): one.station.name for one in self.board.accepted()}
        return {source: (names[source], findings) for source, findings in found.items() if source in names}

    def condition_of(self, source: str) -> StationCondition | None:
        """Return how the station behind the source of an alarm does."""
        return condition_of(self.board, source, self._wiring.clock.mono_s())

    def diagnostics(self) -> dict[str, Any]:
        """Return counters for the diagnostics page."""
        return {
            **self.link.diagnostics(),
            "stations": len(self.board.all()),
            "accepted": len(self.board.accepted()),
            "dropped": dict(self.board.counts),
            "pictures": self.pictures.counts,
            "history": self.history.health(),
        }

    # ---- inside ----

    def _listeners(self) -> FieldListeners:
        return FieldListeners(
            announced=self._announced,
            gone=self.board.gone,
            reported=self.board.reported,
            pictured=self.pictures.take,
            answered=self._answered,
            linked=lambda _is_up: self._changed(""),
        )

    def _announced(self, said: Announcement) -> None:
        self.board.announced(said)
        self.pictures.announced(said.station_id)

    def _answered(self, answer: StationAnswer) -> None:
        self.trigger.answered(answer)
        self.notices.answered(answer)

    def _make_view(self, forecast: Callable[[], dict[str, Any] | None]) -> SensorView:
        wiring = self._wiring
        return SensorView(
            SensorViewParts(
                board=self.board,
                history=self.history,
                database=wiring.records.database,
                clock=wiring.clock,
                authorize=wiring.authorize,
                parcel_name=self.treatment.name_of,
                notice_of=self.notices.of,
                gate=self.gate,
                treated=self.treatment.treated,
                forecast=forecast,
            )
        )

    def _notice_troubles(self) -> dict[str, str]:
        """A notice that is new gets its time to be answered."""
        found = {}
        for known in self.board.accepted():
            notice = self.notices.of(known.station.id)
            if notice is not None and notice.state in (NoticeState.REFUSED, NoticeState.UNCONFIRMED):
                found[known.station.id] = f"{notice.text}"
        return found

    async def round(self) -> None:
        """Bring notices up to date and see time pass; called every few seconds."""
        accepted = self.board.accepted()
        if not accepted:
            return
        self._at_work = self.treatment.look()
        self.notices.round(self.treatment.treatments(self._at_work))
        self._see_time_pass(accepted)

    def _see_time_pass(self, accepted: list[StationNow]) -> None:
        now_s = self._wiring.clock.mono_s()
        states = {one.station.id: one.state(now_s) for one in accepted}
        for station_id, state in states.items():
            if self._states.get(station_id, state) is not state:
                self._changed(station_id)
        self._states = states

    def _changed(self, _station_id: str) -> None:
        """Tell the screens, at most once a second."""
        if not self._is_news_due:
            self._is_news_due = True
            asyncio.get_running_loop().call_later(NEWS_S, self._tell)

    def _tell(self) -> None:
        self._is_news_due = False
        self._wiring.on_event({"kind": "sensors"})

    async def _keep(self) -> None:
        stations = [one.station for one in self.board.accepted() if one.station.heard_at is not None]
        if stations:
            await self._wiring.records.database.run(self.stations.note, stations)

    async def _thin(self) -> None:
        await asyncio.to_thread(self.history.thin, self._wiring.clock.utc())

    async def _every(self, period_s: float, work: Callable[[], Any]) -> None:
        while True:
            await asyncio.sleep(period_s)
            try:
                await work()
            except StoreError as error:
                log.warning("field sensors: %s", error)
            except Exception:  # the next round must come
                log.exception("field sensors failed and go on")

    # ---- the demo ----

    async def _seed(self) -> bool:
        """In the demo, take its stations in at the first start; return whether this is that."""
        wiring = self._wiring
        if not wiring.settings.demo:
            return False
        from hmi.demo.field_past import seed_stations

        found = await asyncio.to_thread(seed_stations, self.stations, wiring.clock.utc())
        for station in found:
            await self.pictures.welcome_new(station)
        return bool(found)

    async def _past(self) -> None:
        from hmi.demo.field_past import record_past

        url = self._wiring.records.database.url.render_as_string(hide_password=False)
        process = SideProcess()
        try:
            await process.run(record_past, url, self._wiring.settings.farm_id, self._wiring.clock.utc())
            self.board.fill(await self._wiring.records.database.run(self.history.newest))
        except Exception:  # the demo works without its past
            log.exception("the past of the demo's stations could not be made")
        finally:
            await asyncio.to_thread(process.close)
