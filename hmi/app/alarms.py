"""Alarms in the console: supervision, live alarms and everybody who hears of them, plugged together."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import datetime, timedelta
from functools import partial
from typing import Any

from fastapi import APIRouter

from hmi.api.alarm_limits import alarm_limits_routes
from hmi.api.alarm_records import AlarmRecordRoutes, alarm_record_routes
from hmi.api.alarms import AlarmRoutes, alarm_routes
from hmi.app.console_health import ConsoleHealth
from hmi.app.farm_ground import FarmGround
from hmi.app.notifications import NotificationRoom
from hmi.app.queue import farm_zone
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.commands.alarm_desk import AlarmDesk
from hmi.commands.alarm_limits_desk import AlarmLimitsDesk, LimitsParts
from hmi.commands.ports import LaneEvent
from hmi.commands.weather import WeatherBoard
from hmi.domain.alarm.alarm import CONSOLE
from hmi.domain.alarm.attendance import Attendance
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.conditions import Change, Conditions
from hmi.domain.alarm.finding import NOTHING, Finding, Findings, detail_of
from hmi.domain.alarm.live_alarm import LiveAlarm, Step, What
from hmi.domain.alarm.shift import ShiftBook
from hmi.domain.event import RobotEvent
from hmi.domain.mission import MissionStatus
from hmi.domain.robot import Robot
from hmi.domain.role import Permission, may
from hmi.domain.sensors.condition import StationCondition
from hmi.domain.stop import StopAttempt, StopState
from hmi.ingest.supervision.console import ConsoleRules, Health
from hmi.ingest.supervision.rules import rules_of
from hmi.ingest.supervision.view import MissionOf, Rule
from hmi.ingest.supervision.watch import Watch
from hmi.presenters import alarms as shown
from hmi.presenters.scene import Scene
from hmi.security.authorization import Authorize
from hmi.settings import Settings
from hmi.store.alarm_journal import AlarmJournal
from hmi.store.alarm_records import AlarmRecords
from hmi.store.alarm_settings import AlarmSettings
from hmi.store.alarms import AlarmStore
from hmi.store.fleet import FleetStore

ROUND_S = 1.0
GRACE_S = 15.0  # robots come back within seconds of a restart
MOVING = (MissionStatus.RUNNING, MissionStatus.PAUSED, MissionStatus.RESUMING)
OLD_S = 10.0  # the screen says from here on that nobody may rely on the list
STATION_SILENT = timedelta(minutes=30)
log = logging.getLogger(__name__)


class AlarmRoom:
    """Everything of alarms of one farm; also the source of lane topic ``alarms``."""

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        records: Records,
        fleet: FleetStore,
        authorize: Authorize,
        mission_of: MissionOf,
        on_event: LaneEvent,
        is_broker_up: Callable[[], bool],
    ) -> None:
        self._clock, self._fleet, self._on_event, self._records = clock, fleet, on_event, records
        self._types = dict(catalogue())  # as shipped, until the limits of this farm are read
        self.store = AlarmStore(clock, self._types)
        self._kept = AlarmRecords(records.database, settings.farm_id, self._words)
        self.store.listeners += [self._kept.take, self._told]
        conditions = self._conditions = Conditions(self._types.__getitem__)
        self.ground = FarmGround(records.features, records.database, settings.farm_id)
        self.watch = Watch(fleet, clock, conditions, self._rules, mission_of, self._apply)
        kept = AlarmSettings(records.database, settings.farm_id)
        self.limits = AlarmLimitsDesk(
            LimitsParts(self._types, conditions.retune, kept, records.database, records.audit, authorize, clock)
        )
        self.desk = AlarmDesk(self.store, records.audit, authorize, clock, self._is_robot, self._shift_end)
        self.journal = AlarmJournal(records.database, settings.farm_id)
        writers = {"Alarm journal": self._kept.health, "History": records.recorder.health}
        writers["Audit"] = lambda: records.audit.health().writer
        self._console = ConsoleRules()
        self._health_of = ConsoleHealth(records, settings.data, clock, is_broker_up, writers, settings.farm_id)
        self._health = Health(is_broker_up=True)
        self.notifications = NotificationRoom(settings, clock, records, authorize, self.store)
        self._shifts = ShiftBook(settings.shift_ends, farm_zone(settings.time_zone))
        self._stations: dict[str, str] = {}
        self.weather: WeatherBoard | None = None
        self.further: dict[str, Callable[[], Findings]] = {}  # what other rooms find wrong with the console
        # by source: its name, what is wrong; None while that cannot be told
        self.stations: Callable[[], Mapping[str, tuple[str, Findings]] | None] = dict
        self._are_stations_known = False
        self.condition_of: Callable[[str], StationCondition | None] = lambda _source: None
        self._troubled: set[str] = set()
        self._weather_source = ""
        self._farm_id, self._started_s = settings.farm_id, clock.mono_s()
        self._missing: set[str] = set()
        self._attendance = Attendance()
        self._task: asyncio.Task[None] | None = None

    # ---- lane ----

    @property
    def revision(self) -> int:
        """See ``AlarmSource``."""
        return self.store.revision

    def entries_since(self, revision: int) -> dict[str, dict[str, Any] | None]:
        """See ``AlarmSource``."""
        changed = self.store.since(revision)
        return {i: None if one is None else shown.entry(one, self.name_of(one.alarm.key.source))
                for i, one in changed.items()}  # fmt: skip

    def summary(self) -> dict[str, Any]:
        """See ``AlarmSource``."""
        flood, now_s = self.store.flood(), self._clock.mono_s()
        since = None if flood is None else (self._clock.utc() - timedelta(seconds=now_s - flood[0]), flood[1])
        return shown.summary(self.store.counts(), since, self.store.checked_s)

    def name_of(self, source: str) -> str:
        """Return what people call a robot, a station or the console."""
        entry = self._fleet.registration(source)
        return shown.name_of(source, entry.name if entry is not None else self._stations.get(source))

    # ---- life ----

    def routes(self) -> list[APIRouter]:
        """Return the REST routes; the records first, for their fixed addresses go before ``/alarms/{id}``."""
        records = self._records
        about = AlarmRecordRoutes(
            store=self.store,
            journal=self.journal,
            history=records.history,
            audit=records.audit,
            database=records.database,
            clock=self._clock,
            name_of=self.name_of,
            scene_of=self._scene,
            contact_of=self._contact,
            responsible_for=lambda source: self.notifications.responsible_for(source),
            per_operator_hour=lambda: self._attendance.per_hour(self._clock.mono_s()),
        )
        live = AlarmRoutes(self.store, self.desk, self._clock, self.name_of)
        settings = [self.notifications.routes(), alarm_limits_routes(self.limits)]
        return [*settings, alarm_routes(live), alarm_record_routes(about)]

    async def prepare(self) -> None:
        """Take over the alarms of before the restart, and read the farm's ground."""
        for alarm, unanswered_at, escalated_at in await self._records.database.run(self._kept.load):
            kind = self._types.get(alarm.key.code)
            if kind is None:
                log.warning("alarm %s is not in the catalogue any more", alarm.key.id)
                continue
            self.store.restore(replace(alarm, is_latching=kind.is_latching), unanswered_at, escalated_at)
        await self.ground.load()
        await self.notifications.desk.load()
        await self.limits.load()

    def start(self) -> None:
        """Begin to look once a second; the registry must be known, and nothing heard yet."""
        for live in self.store.all():
            if live.alarm.is_active:
                self.watch.restore(live.alarm)
        self._kept.start()
        self.notifications.post.start()
        self._task = asyncio.create_task(self._rounds(), name="alarms")

    async def stop(self) -> None:
        """End; what is to be kept is written."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await self.notifications.post.stop()
        await self.ground.close()
        await self._health_of.close()
        await asyncio.to_thread(self._kept.close)

    def health(self) -> dict[str, dict[str, Any]]:
        """Return the part of alarms for ``/api/v1/health``."""
        is_ok = self._clock.mono_s() - self.store.checked_s < OLD_S and self._kept.health().is_ok
        return {"alarms": {"state": "ok" if is_ok else "degraded"}}

    def diagnostics(self) -> dict[str, Any]:
        """Return counters for the diagnostics page."""
        return {
            "listed": len(self.store.all()),
            "dropped": self.store.dropped + self._conditions.dropped,
            "checked_s_ago": round(self._clock.mono_s() - self.store.checked_s, 1),
            "journal": self._kept.health(),
            "notifications": self.notifications.post.health(),
        }

    # ---- what is heard ----

    def see(self, robot: Robot) -> None:
        """Look at a robot that changed."""
        self.watch.see(robot)

    def see_event(self, event: RobotEvent) -> None:
        """Take an event of a robot."""
        self.watch.see_event(event)

    def stop_moved(self, robot_id: str, attempts: Sequence[StopAttempt]) -> None:
        """Take how the presses at a robot went on; an alarm is raised in the same moment."""
        failed = [one for one in attempts if one.state is StopState.NOT_CONFIRMED]
        if not failed:
            self.watch.report(robot_id, "stop", NOTHING)
            return
        oldest = failed[0]
        text = f"{oldest.by} pressed STOP. {oldest.text}".strip()
        self.watch.report(robot_id, "stop", (Finding("stop-not-confirmed", text),))

    def robot_removed(self, robot_id: str) -> None:
        """Let go what is known of a robot that was taken out; one of its name that comes later inherits nothing."""
        self.watch.forget(robot_id)
        self.store.release(robot_id, "It was taken out of the registry.")

    def trouble(self, code: str, text: str) -> None:
        """Take what the connection to the robots reports."""
        log.warning("%s: %s", code, text)
        self._console.trouble(code, text, self._clock.mono_s())

    async def round(self, late_s: float = 0.0) -> None:
        """Look at everything once."""
        self._health = await self._health_of.gather(late_s)
        now_s = self._clock.mono_s()
        self._attendance.see(now_s, self._operators())
        self.watch.report(CONSOLE, "console", self._console.look(self._health, now_s))
        self.watch.report(CONSOLE, "notifications", self.notifications.findings())
        for name, look in self.further.items():
            self._each(name, partial(self._look_further, name, look))
        self._each("gateway", self._look_at_gateway)
        self._each("weather", self._look_at_weather)
        self._each("stations", self._look_at_stations)
        self._look_for_missing(now_s)
        if now_s - self._started_s >= GRACE_S:
            self.watch.let_go_restored(self._is_judged)
        for _ in self.watch.sweeping():
            await asyncio.sleep(0)
        self.store.pass_time()
        self._kept.mend(self.store.all())

    async def _rounds(self) -> None:
        loop, late_s = asyncio.get_running_loop(), 0.0
        while True:
            try:
                await self.round(late_s)
            except Exception:  # the next round must come whatever one value is
                log.exception("a round of the supervision failed")
            due_s = loop.time() + ROUND_S
            await asyncio.sleep(ROUND_S)
            late_s = loop.time() - due_s

    def _each(self, what: str, look: Callable[[], None]) -> None:
        try:
            look()
        except Exception:  # a fault over one thing must not keep the robots from being looked at
            log.exception("the supervision could not look at %s", what)

    def _look_further(self, name: str, look: Callable[[], Findings]) -> None:
        self.watch.report(CONSOLE, name, look())

    def _look_at_gateway(self) -> None:
        told = self._health_of.not_confirmed
        for robot_id in self._fleet.registered_ids():
            found = (Finding("stop-not-confirmed", told[robot_id]),) if robot_id in told else NOTHING
            self.watch.report(robot_id, "gateway", found)

    def _look_at_weather(self) -> None:
        latest = self.weather.latest if self.weather is not None else None
        if latest is None or self.weather is None:
            return
        if self.weather.is_measured_here:  # the farm's own stations have alarms of their own
            if self._weather_source:
                self.watch.report(self._weather_source, "weather", NOTHING)
            return
        source = self._weather_source = detail_of(latest.station) or "station"
        self._stations[source] = latest.station
        is_silent = self._clock.utc() - latest.at > STATION_SILENT
        text = "Nothing for half an hour. Rain and wind are not known."
        self.watch.report(source, "weather", (Finding("sensor-silent", text),) if is_silent else NOTHING)

    def _look_at_stations(self) -> None:
        found = self.stations()
        self._are_stations_known = found is not None
        if found is None:
            return
        for source in self._troubled - found.keys():
            self.watch.report(source, "station", NOTHING)
        for source, (name, findings) in found.items():
            self._stations[source] = name
            self.watch.report(source, "station", findings)
        self._troubled = set(found)

    def _is_judged(self, source: str, code: str) -> bool:
        """Say whether everybody who reports this of a source has looked at it since the console started."""
        if source == CONSOLE or self._is_robot(source):
            return code != "audit-broken" or self._health_of.is_audit_known
        if not self._are_stations_known:
            return False
        if self.condition_of(source) is not None:
            return True
        # a weather station that is not the farm's own: known by its first report, or silent by itself again
        is_heard = self.weather is None or self.weather.latest is not None
        return is_heard or self._clock.mono_s() - self._started_s >= STATION_SILENT.total_seconds()

    def _look_for_missing(self, now_s: float) -> None:
        """Miss robots that had a mission under way and were not heard since the console started."""
        if now_s - self._started_s < GRACE_S:
            return
        missing = {one for one in self._fleet.registered_ids() if not self._fleet.was_heard(one)}
        known = self._records.missions.all_known(self._farm_id) if missing or self._missing else []
        away = {one.robot_id for one in known if one.status in MOVING and one.robot_id in missing}
        for robot_id in away | self._missing:
            text = "Not heard since Headland was started; its mission was under way."
            found = (Finding("link-lost", text),) if robot_id in away else NOTHING
            self.watch.report(str(robot_id), "missing", found)
        self._missing = {one for one in away if one is not None}

    def _rules(self) -> Sequence[Rule]:
        return rules_of(self._types, lambda: self.ground.now)

    def _apply(self, changes: list[Change]) -> None:
        if changes:
            self.store.apply(changes)

    def _told(self, step: Step) -> None:
        if step.what is What.RAISED and step.live.alarm.is_annunciated:
            self._attendance.raised(self._clock.mono_s())
        name = self.name_of(step.live.alarm.key.source)
        self._on_event(shown.event(step, name))
        self.notifications.tell(step, name)

    def _words(self, live: LiveAlarm) -> tuple[str, str]:
        return self.name_of(live.alarm.key.source), shown.title_of(live)

    def _is_robot(self, source: str) -> bool:
        return source != CONSOLE and self._fleet.registration(source) is not None

    def _shift_end(self) -> datetime:
        return self._shifts.end_after(self._clock.utc())

    def _contact(self, source: str) -> dict[str, str] | None:
        entry = self._fleet.registration(source)
        if entry is None or not entry.contact_name:
            return None
        return {"name": entry.contact_name, "phone": entry.contact_phone or ""}

    def _operators(self) -> int:
        return len({one.user_id for one in self._records.sessions.all() if may(one.role, Permission.ACKNOWLEDGE_ALARM)})

    def _scene(self, source: str) -> Scene:
        robots = [one for one in self._fleet.robots() if one.is_registered]
        health = self._health
        return Scene(
            now_s=self._clock.mono_s(),
            robot=next((one for one in robots if one.id == source), None),
            others=[one for one in robots if one.id != source],
            is_broker_up=health.is_broker_up,
            parts=health.parts,
            disk=health.disk_free,
            is_database_up=health.is_database_up,
            writers=health.writers,
            station=self.condition_of(source),
        )
