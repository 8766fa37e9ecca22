"""One console: every service built once and plugged into the others."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Sequence
from typing import Any

from hmi.api.health import KeeperReport
from hmi.api.metrics import ConsoleMetrics
from hmi.app.alarms import AlarmRoom
from hmi.app.arrival_report import ArrivalReport, FromRobots
from hmi.app.base_maps import BaseMapDesk
from hmi.app.camera_calls import camera_calls
from hmi.app.camera_rule import CameraRule, bare_camera
from hmi.app.cameras import CameraDesk
from hmi.app.chores import Chores
from hmi.app.cloud import CloudRoom
from hmi.app.edge import Edge
from hmi.app.fleet import FleetDesk
from hmi.app.forecast import ForecastRoom
from hmi.app.maps import MapDesk
from hmi.app.missions import MissionDesk
from hmi.app.pictures import PictureDesk
from hmi.app.queue import QueueDesk
from hmi.app.records import Records
from hmi.app.sensors import SensorRoom, SensorWiring
from hmi.app.stop_relay import StopRelay
from hmi.app.stops import StopDesk
from hmi.app.twin import TwinDesk
from hmi.app.witness import FleetWitness
from hmi.clock import Clock
from hmi.cloud.cameras import FieldCamera
from hmi.commands.desk import CommandDesk, CommandPorts
from hmi.commands.drive import DriveFrame, JogFrame
from hmi.commands.lease_words import asked_of, owner_of
from hmi.domain.event import RobotEvent
from hmi.domain.robot import SafetyState
from hmi.live.frames import Drive, Here, Jog
from hmi.live.hub import LiveHub
from hmi.security.authorization import Authorizer
from hmi.security.session_info import SessionInfo
from hmi.settings import Settings

REFUSAL_TOLD_S = 1.0


class Console:
    """All services of the console process. Make one with ``prepare``; ``start`` and ``stop`` it on the event loop."""

    def __init__(self, settings: Settings, clock: Clock, records: Records, edge: Edge, epoch: int) -> None:
        self.settings, self.clock, self.records, self.edge = settings, clock, records, edge
        self.authorize = Authorizer(records.robots.of_any_farm)
        self.keeper, self.metrics = KeeperReport(settings.data), ConsoleMetrics()
        self._tasks: set[asyncio.Task[None]] = set()
        self._undo: list[Callable[[], None]] = []
        self._refusals: dict[tuple[str, str], float] = {}
        self._open_knowledge()
        self._open_commands(epoch)
        self._open_pictures()
        self._tell_each_other()

    def _open_knowledge(self) -> None:
        """Missions, maps and alarms, and the lane that shows them."""
        settings, clock, records, edge = self.settings, self.clock, self.records, self.edge
        self.missions = MissionDesk(settings, clock, records, edge.fleet, self.authorize, self._lane_event)
        self.maps = MapDesk(settings, clock, records, edge.fleet, self.authorize, self._lane_event)
        self.base_maps = BaseMapDesk(settings, records, clock, self.authorize, self._lane_event)
        self.alarms = AlarmRoom(
            settings,
            clock,
            records,
            edge.fleet,
            self.authorize,
            self.missions.facts.of,
            self._lane_event,
            lambda: edge.coordinator.is_broker_up,
        )
        self.hub = LiveHub(
            edge.fleet,
            edge.ticks,
            clock,
            self.missions.title_of,
            self.missions.facts.of,
            self.alarms,
            is_supervised=self.missions.start_rules.is_supervised,
        )
        self.chores = Chores(records, self.hub, self.keeper, clock)
        self.twin = TwinDesk.of(settings, records, edge.fleet, self.authorize, clock)
        self.arrivals = ArrivalReport(edge.coordinator.arrivals, edge.fleet, clock)
        robots = FromRobots(lambda: edge.coordinator.tally.total, self.arrivals.whole)
        self.cloud = CloudRoom(settings, clock, records, edge.fleet, robots, self._lane_event)
        self.forecast = ForecastRoom(settings, clock, records)

    def _open_commands(self, epoch: int) -> None:
        """Commands to one robot, to several, by the queue, and STOP's second path."""
        settings, clock, records, edge = self.settings, self.clock, self.records, self.edge
        self.desk = CommandDesk(
            CommandPorts(
                fleet=edge.fleet,
                ticks=edge.ticks,
                sender=edge.sender,
                audit=records.audit,
                missions=self.missions.book,
                clock=clock,
                authorize=self.authorize,
                on_event=self._lane_event,
                epoch=epoch,
                next_epoch=self._next_epoch,
                start_rules=self.missions.start_rules,
                is_signed_in=lambda session_id: records.sessions.get(session_id) is not None,
                pressers=lambda robot_id: self.stops.pressers(robot_id),
            )
        )
        self.queue = QueueDesk(
            settings,
            clock,
            records,
            edge.fleet,
            edge.ticks,
            self.desk,
            self.missions.book,
            self.authorize,
            self._lane_event,
        )
        self.fleet = FleetDesk(settings, clock, records, edge.fleet, self.desk, self.authorize, self._lane_event)
        self.chores.further += [self.fleet.duty.let_go, self._agree_keep_out]
        self.stops = StopDesk(
            edge.sender,
            clock,
            records.robots,
            records.audit,
            self.desk.leases,
            settings.data / "stop" / "outbox.json",
            on_stop=self._stopped,
            on_stop_all=self.queue.freeze.stop_all,
            on_move=self._stop_moved,
            on_new=lambda stop_id, token: self.stop_relay.press(stop_id, token),
        )
        self.stop_relay = StopRelay(settings, self.stops.service.open_at)

    def _open_pictures(self) -> None:
        """Cameras, what is kept of them, and stations, which send pictures too."""
        settings, clock, records, edge = self.settings, self.clock, self.records, self.edge
        self.cameras = CameraDesk.of(settings, records, edge.fleet, self.authorize, edge.sender)
        self.pictures = PictureDesk(
            settings,
            clock,
            records,
            edge.fleet,
            self.authorize,
            self._lane_event,
            self.missions.title_of,
            camera_calls(self.cameras),
        )
        self.cameras.rule = CameraRule(self.pictures.sources)
        self.cameras.on_new = self.pictures.frames.show_again
        self.sensors = SensorRoom(
            SensorWiring(
                settings, clock, records, edge.fleet, self.authorize, self._lane_event, self.queue.weather,
                self.pictures,
            )
        )  # fmt: skip
        self.twin.cameras = camera_calls(self.cameras)

    def _tell_each_other(self) -> None:
        """Plug together what knows of each other only here."""
        records, edge = self.records, self.edge
        self.alarms.weather = self.queue.weather
        self.alarms.further["cloud"] = self.cloud.findings
        self.alarms.stations, self.alarms.condition_of = self.sensors.findings, self.sensors.condition_of
        self.queue.treatment = self.sensors.gate
        self.sensors.on_loaded.append(lambda work: self.cloud.watch_stations(work.board))
        self.cloud.watch_cameras(
            lambda: [FieldCamera(bare_camera(one), self.sensors.place_of(one.camera))
                     for one in self.pictures.sources.field_cameras()]
        )  # fmt: skip
        self.queue.forecast = self.forecast.latest
        self.sensors.forecast = self.forecast.row
        for room in (self.missions.planner, self.forecast):
            self.cloud.services.append(room.report)
        self.alarms.further["planner"] = self.missions.planner.findings
        self.alarms.further["forecast"] = self.forecast.findings
        self.desk.missions.cloud = self.cloud if self.cloud.is_on else None
        self.alarms.notifications.responsible_for = self._responsible_for
        self.alarms.store.listeners.append(self.pictures.recorder.alarm)
        self.alarms.further["pictures"] = self.pictures.findings
        see = [records.recorder.see, self.missions.tracking.see, self.alarms.see, self.pictures.recorder.see]
        self._witness = FleetWitness(edge.fleet, self.clock, self.stops.service.on_return, see)

    @classmethod
    async def prepare(cls, settings: Settings, clock: Clock) -> Console:
        """Open the database and build everything; nothing runs yet.

        Raises:
            StoreError: the database cannot be used.
        """
        edge = Edge(settings, clock)
        records = Records(settings, clock, lambda robot_id: edge.fleet.registration(robot_id) is not None)
        await asyncio.to_thread(records.open)
        await records.sessions.load()
        epoch = await asyncio.to_thread(records.counters.next_epoch, "lease")
        console = cls(settings, clock, records, edge, epoch)
        await console.missions.prepare()
        await console.base_maps.prepare()
        await console.queue.prepare()
        await console.fleet.prepare()
        await console.pictures.prepare()
        await console.alarms.prepare()
        return console

    async def start(self) -> None:
        """Start writers, the broker connection, the live lane and everything that watches."""
        self.records.start()
        self.sync_registry()
        self.alarms.start()
        self._listen()
        await self.edge.start()
        await self.hub.start()
        self.desk.start()
        self.stops.start()
        self.missions.start()
        self.queue.start()
        self.fleet.start()
        self.pictures.start()
        self.chores.start()
        self.sensors.start()
        self.cloud.start()
        self.forecast.start()

    async def stop(self) -> None:
        """End everything in the opposite order; what is queued is written."""
        await self.forecast.stop()
        await self.cloud.stop()
        await self.sensors.stop()
        await self.twin.stop()
        await self.alarms.stop()
        await self.chores.stop()
        for undo in self._undo:
            undo()
        await self.pictures.stop()
        await self.cameras.stop()
        await self.fleet.stop()
        await self.queue.stop()
        await self.missions.stop()
        await self.maps.stop()
        await self.base_maps.stop()
        await self.stop_relay.close()
        await self.stops.stop()
        await self.desk.close()
        await self.hub.stop()
        await self.edge.stop()
        await asyncio.to_thread(self.records.close)

    def sync_registry(self) -> None:
        """Let everybody know which robots are registered now; call it on the loop."""
        before = set(self.edge.fleet.registered_ids())
        self.edge.fleet.set_registry(self.records.robots.all())
        gone = before - set(self.edge.fleet.registered_ids())
        for robot_id in gone:
            self.alarms.robot_removed(robot_id)
        if gone:
            self._soon(self.fleet.duty.let_go(robots=gone))
            self._soon(self.queue.book.robots_removed(gone))

    def client_frame(self, session: SessionInfo, lane_id: str, frame: Here | Drive | Jog) -> None:
        """Take a ``here``, ``drive`` or ``jog`` frame of a browser."""
        if isinstance(frame, Here):
            for robot_id in frame.each():
                self.desk.pulse.here(session, robot_id, frame.tick)
            return
        picture_s = None if frame.picture is None else frame.picture / 1000
        if isinstance(frame, Jog):
            joints = JogFrame(frame.robot, frame.rates, frame.tick, picture_s)
            kind, verdict = "jog", self.desk.drive.jog(session, lane_id, joints)
        else:
            setpoint = DriveFrame(frame.robot, frame.v, frame.w, frame.tick, picture_s)
            kind, verdict = "drive", self.desk.drive.setpoint(session, lane_id, setpoint)
        if not verdict.is_forwarded and self._is_new_refusal(lane_id, verdict.code):
            told = {"kind": kind, "robot": frame.robot, "code": verdict.code, "text": verdict.text}
            self.hub.event(told, session_id=session.session_id)

    def _is_new_refusal(self, lane_id: str, code: str) -> bool:
        """Frames come ten times a second; the same reason is told once a second and lane."""
        now_s = self.clock.mono_s()
        self._refusals = {key: at for key, at in self._refusals.items() if now_s - at < REFUSAL_TOLD_S}
        return self._refusals.setdefault((lane_id, code), now_s) == now_s

    def _listen(self) -> None:
        hear = self.edge.coordinator.listeners
        hear.on_ack += [self._acknowledged, self.stops.service.on_ack]
        hear.on_safety += [self._safety, self.stops.service.on_safety]
        hear.on_event += [self.records.recorder.see_event, self.alarms.see_event, self.fleet.see_event]
        hear.on_event.append(self._robot_event)
        hear.on_trouble.append(self.alarms.trouble)
        if self.cloud.is_on:
            self.records.recorder.on_event.append(self.cloud.news.see_event)  # with its mission, and changes of mode
            self.alarms.store.listeners.append(self.cloud.news.see_alarm)
        self.desk.ledger.when_settled(self.metrics.observe)
        self.desk.ledger.when_settled(self.missions.acts.settled)
        self._undo = [
            self.records.sessions.on_ended(self._session_ended),
            self._witness.start(),
        ]

    def _responsible_for(self, robot_id: str) -> str:
        found = self.fleet.duty.responsible_for(robot_id)
        return "" if found is None else found.user_name

    def _acknowledged(self, answer: Any) -> None:
        self.desk.ledger.acknowledged(answer)
        self.desk.drive.refused_by_robot(answer)

    def _stopped(self, robot_id: str, by: str) -> None:
        try:
            self.queue.stopped(robot_id, by)
        finally:
            self.pictures.recorder.stopped(robot_id, by)

    async def _agree_keep_out(self) -> None:
        """The STOP banner asks for the same distance as map and twin."""
        sheets = [(one.id, one.factsheet) for one in self.edge.fleet.robots() if one.is_registered]
        said = {robot_id: sheet.keep_out_m for robot_id, sheet in sheets if sheet is not None}
        await asyncio.to_thread(self.records.stop_list.learn_keep_out, said)

    def _stop_moved(self, robot_ids: Sequence[str]) -> None:
        for robot_id in robot_ids:
            self.alarms.stop_moved(robot_id, self.stops.service.attempts_at(robot_id))

    def _safety(self, robot_id: str, _safety: SafetyState) -> None:
        robot = self.edge.fleet.robot(robot_id)
        if robot is None:
            return
        self.queue.see(robot)
        self.desk.leases.observe(robot)  # each time: a button that is pressed again must have been seen released

    def _robot_event(self, event: RobotEvent) -> None:
        told = {"kind": "robot", "robot": event.robot_id, "name": event.name, "text": event.text, "what": event.kind}
        self.hub.event(told)

    def _session_ended(self, session: SessionInfo, text: str) -> None:
        self.desk.leases.end_session(session.session_id)
        self.hub.end_session(session.session_id, "signed_out", text)

    def _lane_event(self, event: dict[str, Any]) -> None:
        self.hub.event(event)
        if event.get("kind") == "map" and event.get("what") == "published":
            self.missions.facts.map_published()
            self.alarms.ground.map_published()
            self._soon(self.cloud.map_published())
            self._soon(self.sensors.map_published())
        if event.get("kind") == "lease":
            self.show_lease(str(event["robot"]))

    def _soon(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.get_running_loop().create_task(work, name="console-soon")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def show_lease(self, robot_id: str) -> None:
        """Tell the browsers who has control of a robot."""
        lease = self.desk.leases.of(robot_id)
        shown = {"owner": owner_of(lease), "asked": asked_of(lease)}
        self.hub.set_group(robot_id, "lease", shown)

    async def _next_epoch(self) -> int:
        return await asyncio.to_thread(self.records.counters.next_epoch, "lease")
