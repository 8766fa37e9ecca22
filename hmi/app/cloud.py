"""The cloud in the console; nothing at all if no cloud is set.

What speaks to the broker is loaded some seconds after the start: nobody waits for it.
"""

from __future__ import annotations

import asyncio
import importlib
import logging
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter

from backend_clients.http.trouble import OutsideError
from hmi.api.cloud import CloudRefused, cloud_routes, proposal_routes
from hmi.api.metrics import Gauge
from hmi.app.arrival_report import FromRobots
from hmi.app.records import Records
from hmi.app.service_report import broker_findings, link_report
from hmi.clock import Clock
from hmi.cloud.backlog import Backlog
from hmi.cloud.broker_link import broker_link
from hmi.cloud.cameras import CameraStates, FieldCamera
from hmi.cloud.counts import Counts
from hmi.cloud.newest import Newest
from hmi.cloud.news import CloudNews
from hmi.cloud.outbox import Outbox
from hmi.cloud.proposals import ProposalBook
from hmi.commands.map_book import MapBook, parsed
from hmi.commands.map_proposals import MapProposals
from hmi.commands.ports import LaneEvent
from hmi.domain.alarm.finding import NOTHING, Findings
from hmi.domain.command import Acknowledgement, OrderFailed
from hmi.domain.family import Family
from hmi.domain.mission import MissionStatus
from hmi.fiware.farm_map import map_entities
from hmi.fiware.map_change import signed
from hmi.fiware.urn import KeyValues, Urns
from hmi.mapping.feature import MapFeature, as_geojson
from hmi.presenters.cloud import words_of
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.service_link import NOT_OURS, LinkState
from hmi.settings import Settings
from hmi.store.audit_chain import AuditEntry
from hmi.store.errors import StoreError
from hmi.store.fleet import FleetStore
from hmi.store.missions import Mission

if TYPE_CHECKING:
    from hmi.app.cloud_work import CloudWork
    from hmi.store.sensor_board import SensorBoard

LATER_S = 5.0  # as the processes that nobody waits for
SETTLE_S = 5.0
MISSIONS_TOLD = 300  # newest missions told when a tenant knows nothing of us
log = logging.getLogger(__name__)


class CloudRoom:
    """Everything about the cloud of one farm."""

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        records: Records,
        fleet: FleetStore,
        robots: FromRobots,
        on_event: LaneEvent,
    ) -> None:
        self._settings, self._clock, self._records, self._fleet = settings, clock, records, fleet
        self._robots, self._on_event = robots, on_event
        self._urns = Urns(settings.farm_id)
        self.book = ProposalBook(self._urns)
        self._features: tuple[int, dict[str, MapFeature]] | None = None
        self._task: asyncio.Task[None] | None = None
        self._work: CloudWork | None = None
        self._others: list[Newest] = []
        folder = settings.data / "cloud"
        outbox = Outbox(folder / "outbox.db", settings.cloud_outbox_mb * 2**20, settings.cloud_outbox_days * 86_400)
        self._backlog = Backlog(outbox, clock)
        self._link = broker_link(clock)
        self.services: list[Callable[[], dict[str, Any]]] = []  # rows of other services outside
        self.news = CloudNews(self._urns, clock, self._backlog.put, self._family_of)

    @property
    def is_on(self) -> bool:
        """Whether a cloud is set."""
        return self._settings.cloud_url is not None

    def routes(self, maps: MapBook, authorize: Authorize) -> list[APIRouter]:
        """Return the REST routes."""
        proposals = MapProposals(self.book, maps, authorize, self._records.audit, self._refused)
        return [cloud_routes(self), proposal_routes(self, proposals)]

    def _refused(self) -> None:
        self._proposals_changed()
        self.tell_map()

    def start(self) -> None:
        """Begin to mirror, if a cloud is set."""
        if not self.is_on:
            return
        loop = asyncio.get_running_loop()

        def changed(mission: Mission) -> None:  # in the thread that changed it
            if mission.status is not MissionStatus.DRAFT:  # nobody plans to do it yet
                loop.call_soon_threadsafe(self._mission, mission)

        def deleted(mission: Mission) -> None:
            if mission.status is not MissionStatus.DRAFT:
                loop.call_soon_threadsafe(self._deleted, mission)

        self._records.missions.on_changed(changed)
        self._records.missions.on_deleted(deleted)
        self._task = asyncio.create_task(self._run(), name="cloud")

    async def stop(self) -> None:
        """End it; what waits is on disk."""
        if self._task is None:
            return
        self._task.cancel()
        await asyncio.gather(self._task, return_exceptions=True)
        await self._backlog.close()
        if self._work is not None:
            await self._work.close()

    async def upload_mission(self, robot_id: str, document: dict[str, Any]) -> Acknowledgement:
        """Send a mission through the cloud; see ``MissionWay``. What was read back stands in the mission's log."""
        if self._link.state in NOT_OURS:
            text = f"{words_of(self._link.state.value).head}: nothing was sent. Send the mission directly."
            raise OrderFailed("cloud_not_ours", text, is_outcome_known=True)
        if self._work is None:
            text = "The link to the cloud is not up yet. Try again in a moment, or send the mission directly."
            raise OrderFailed("cloud_away", text, is_outcome_known=True)
        begin_s = self._clock.mono_s()
        answer = await self._work.missions.upload_mission(robot_id, document)
        if answer.is_accepted:
            robot = self._fleet.robot(robot_id)
            name = robot_id if robot is None else robot.name
            why = f"Went to {name} through the cloud, read back after {self._clock.mono_s() - begin_s:.1f} s."
            await self._note(document["mission_id"], why)
        return answer

    async def _note(self, mission_id: str, why: str) -> None:
        records, farm = self._records, self._settings.farm_id
        try:
            await records.database.run(records.missions.note, farm, mission_id, "cloud", why)
        except StoreError:  # the robot has it all the same
            log.exception("the log of mission %s lacks: %s", mission_id, why)

    def watch_stations(self, board: SensorBoard) -> None:
        """Mirror field stations too, if a cloud is set."""
        if not self.is_on:
            return
        from hmi.cloud.stations import StationStates  # with the stations themselves, some seconds after the start

        self._others.append(StationStates(board, self._urns))

    def watch_cameras(self, field: Callable[[], Iterable[FieldCamera]]) -> None:
        """Mirror which cameras there are, if a cloud is set."""
        if self.is_on:
            self._others.append(CameraStates(self._fleet, field, self._urns, self._clock))

    def tell_map(self) -> None:
        """Tell the map again."""
        if self._work is not None:
            self._work.mirror.tell_whole()

    async def map_published(self) -> None:
        """Take a map that was published: what it fulfils of the cloud's wishes is done."""
        if self._work is not None and self.book.published(await self._published()):
            self._proposals_changed()
        self.tell_map()

    def proposals(self) -> list[dict[str, Any]]:
        """See ``CloudDesk``."""
        return [
            {
                "id": one.id, "kind": one.kind, "name": one.name, "what": one.what, "text": one.text,
                "problem": one.problem, "utc": one.at.isoformat(timespec="milliseconds"),
                "before": None if one.before is None else as_geojson(one.before),
                "after": None if one.after is None else as_geojson(one.after),
            }
            for one in self.book.all()
        ]  # fmt: skip

    def lets_in(self, secret: str, source: str) -> bool:
        """See ``Notified``."""
        hints = None if self._work is None else self._work.hints
        return hints is not None and hints.lets_in(secret, source)

    def hint(self, body: bytes, headers: dict[str, str]) -> bool:
        """See ``Notified``."""
        hints = None if self._work is None else self._work.hints
        return hints is not None and hints.take(body, headers)

    async def take_tenant(self, session: SessionInfo) -> None:
        """See ``CloudDesk``."""
        if self._work is None:
            raise CloudRefused("There is no link to a cloud.")
        await self._work.take_tenant()
        self._audit(session, "tenant_taken", f"{self._settings.cloud_tenant or 'default'} {self._settings.cloud_path}")

    async def send_refused(self, session: SessionInfo) -> None:
        """See ``CloudDesk``."""
        if self._work is None:
            raise CloudRefused("There is no link to a cloud.")
        self._work.mirror.send_again()
        self._audit(session, "refused_sent_again", "")

    async def forget_refused(self, session: SessionInfo) -> None:
        """See ``CloudDesk``."""
        if self._work is None:
            raise CloudRefused("There is no link to a cloud.")
        count = await self._work.mirror.forget_refused()
        self._audit(session, "refused_forgotten", f"{count} records")

    def _audit(self, session: SessionInfo, what: str, text: str) -> None:
        user, device = session.user_name, session.device_name or ""
        self._records.audit.append(AuditEntry(session.farm_id, user, device, "cloud", what, text=text))

    def findings(self) -> Findings:
        """Return what is wrong with the link for the alarms."""
        if self._work is not None:
            return self._work.report.findings()
        is_misset = self._link.state is LinkState.MISSET
        return broker_findings(self._link, self._backlog.total) if is_misset else NOTHING

    def health(self) -> dict[str, dict[str, Any]]:
        """Return the part of the cloud for ``/api/v1/health``."""
        if self._work is not None:
            return self._work.report.health()
        is_misset = self._link.state is LinkState.MISSET
        return {"cloud": {"state": "degraded", "url": self._settings.cloud_url}} if is_misset else {}

    def gauges(self) -> list[Gauge]:
        """Return the figures of the way to the cloud for Prometheus; zeros where no cloud is set."""
        waiting = self._backlog

        def counts() -> Counts:
            return Counts() if self._work is None else self._work.mirror.counts

        def dropped() -> int:
            return waiting.waiting.lost + (0 if self._work is None else self._work.refused.dropped)

        def refused() -> int:
            return 0 if self._work is None else len(self._work.refused.all())

        return [
            Gauge("cloud_refused_kept", "Records that the cloud refused and that are kept here.", refused),
            Gauge("cloud_waiting", "Records that are not in the cloud yet.", lambda: waiting.total),
            Gauge("cloud_waiting_bytes", "Their size on disk.", lambda: waiting.waiting.bytes),
            Gauge(
                "cloud_dropped",
                "Records that the cloud will never have.",
                dropped,
                "",
                True,
            ),
            Gauge("cloud_refused", "Entities that the cloud refused.", lambda: counts().refused, "", True),
            Gauge("cloud_sent_twice", "Entities sent again after a lost answer.", lambda: counts().resent, "", True),
            Gauge("cloud_sent", "Entities that arrived in the cloud.", lambda: counts().arrived, "", True),
        ]

    def report(self) -> dict[str, Any]:
        """See ``CloudDesk``."""
        return {**self._own_report(), "services": [report() for report in self.services]}

    def _own_report(self) -> dict[str, Any]:
        if self._work is not None:
            return self._work.report.whole()
        if self.is_on:
            where = {"url": self._settings.cloud_url, "tenant": self._settings.cloud_tenant}
            return {**link_report(self._link, words_of(self._link.state.value), self._clock), **where}
        words = words_of("off")
        return {"state": "off", "head": words.head, "text": words.text, "level": words.level}

    async def _run(self) -> None:
        await asyncio.sleep(LATER_S)
        await asyncio.to_thread(importlib.import_module, "hmi.app.cloud_work")
        from hmi.app.cloud_work import CloudWork, WorkParts, make_client  # loaded above, beside the event loop

        try:
            client = await asyncio.to_thread(make_client, self._settings)
            parts = WorkParts(self._settings, self._clock, self._urns, self._fleet, self._backlog, self.book,
                              self._robots, client, self._link, lambda: self._others)  # fmt: skip
            while self._work is None:
                try:
                    self._work = CloudWork(parts, self._whole, self._published, self._proposals_changed)
                except OSError as error:  # a disk that takes nothing now may do so later
                    why = f"The folder of the cloud cannot be used: {error}"
                    self._link.leave(LinkState.MISSET, why, "Check room and rights of the data folder.")
                    await self._backlog.settle()
                    await asyncio.sleep(SETTLE_S)
        except OutsideError as error:  # nothing can ever be sent with these settings
            self._link.failed(error)
            await self._only_keep()
            return
        self._link.ask_now()
        said = ""
        while True:
            try:
                await self._work.round()
                said = ""
            except Exception as error:  # the next round must come whatever one value is
                if said != repr(error):  # a database that is away is told once, not each second
                    log.exception("a round of the cloud failed")
                said = repr(error)
            await asyncio.sleep(self._settings.cloud_period_s)

    async def _only_keep(self) -> None:
        """Bring to disk what happens; with other settings it goes up after a restart."""
        while True:
            await self._backlog.settle()
            await asyncio.sleep(SETTLE_S)

    async def _whole(self) -> Sequence[KeyValues]:
        features = list((await self._published()).values())
        farm, name = self._settings.farm_id, self._settings.farm_name
        found = await asyncio.to_thread(lambda: [signed(one) for one in map_entities(features, farm, name)[0]])
        known = self._records.missions.all_known(farm)
        newest = [one for one in known if one.status is not MissionStatus.DRAFT][:MISSIONS_TOLD]
        return [*self.book.held_back(found), *(self.news.operation(one) for one in newest)]

    async def _published(self) -> dict[str, MapFeature]:
        farm, records = self._settings.farm_id, self._records
        version = await records.database.run(records.maps.published, farm)
        if self._features is None or self._features[0] != version.number:
            raw = await records.database.run(records.maps.features_of, farm, version.number)
            self._features = version.number, await asyncio.to_thread(parsed, raw)
        return self._features[1]

    def _proposals_changed(self) -> None:
        self._on_event({"kind": "map", "what": "proposals", "count": len(self.book.all())})

    def _mission(self, mission: Mission) -> None:
        if mission.farm_id == self._settings.farm_id:
            self.news.see_mission(mission)

    def _deleted(self, mission: Mission) -> None:
        if mission.farm_id == self._settings.farm_id:
            self.news.see_deleted(mission)

    def _family_of(self, robot_id: str) -> Family | None:
        robot = self._fleet.robot(robot_id) if robot_id else None
        return None if robot is None or robot.factsheet is None else robot.factsheet.family
