"""A console's field sensors against a broker that a test plays; every clock moves only when told."""

from __future__ import annotations

import asyncio
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
from fastapi import FastAPI

from backend_clients.edge.mqtt import LinkState, OnLink, OnMessage
from backend_clients.field import messages as m
from backend_clients.field.codec import encode
from backend_clients.field.topics import Address, Down, Up, parse, topic
from hmi.api import errors
from hmi.api.access import Access
from hmi.app.sensor_work import SensorWork
from hmi.app.sensors import SensorRoom, SensorWiring
from hmi.commands.sensor_book import StationWish
from hmi.commands.weather import WeatherBoard
from hmi.domain.mission import MissionStatus
from hmi.domain.robot import OrderStatus
from hmi.domain.role import Role
from hmi.ingest.coordinator import OnFault
from hmi.planning.mission import plan_mission
from hmi.store.features import Feature
from hmi.store.missions import Mission
from tests.hmi.commands.field import FARM
from tests.hmi.missions.rig import Fleet as PlainFleet
from tests.hmi.missions.rig import NoTokens
from tests.hmi.missions.rig import order as order_of
from tests.hmi.missions.test_document import wish
from tests.hmi.pictures.rig import WEEDER, PictureRig

PARCEL, INSIDE, OUTSIDE = "north", (52.005, 5.005), (52.05, 5.05)
RING = [[5.0, 52.0], [5.01, 52.0], [5.01, 52.01], [5.0, 52.01], [5.0, 52.0]]
BOOT = "boot-000001"
MISSION = "wheat-1"


class PlayedLink:
    """A connection whose other end is the test."""

    def __init__(self, on_message: OnMessage, on_link: OnLink) -> None:
        self._on_message, self._on_link = on_message, on_link
        self.is_up, self.is_alive, self.starts = True, True, 0
        self.published: list[tuple[Address, bytes, int, bool]] = []
        self.asked = asyncio.Event()

    def start(self) -> None:
        """See ``BrokerLink``."""
        self.is_alive, self.starts = True, self.starts + 1
        self._on_link(LinkState.UP, "here")

    def stop(self) -> None:
        """See ``BrokerLink``."""

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """See ``BrokerLink``."""
        if self.is_up:
            self.published.append((parse(topic), payload, qos, retain))
            self.asked.set()
        return self.is_up

    def deliver(self, topic: str, payload: bytes, *, is_retained: bool = False) -> None:
        """Let something arrive."""
        self._on_message(topic, payload, is_retained)


class _Store:
    """The live store as the room reads it."""

    def __init__(self, fleet: PlainFleet) -> None:
        self._fleet = fleet

    def robots(self) -> list[Any]:
        """See ``FleetStore``."""
        return list(self._fleet.robots.values())


def live_store(fleet: PlainFleet) -> Any:
    """Return the robots as the room reads them."""
    return _Store(fleet)


class SensorRig(PictureRig):
    """Everything about field sensors of one farm."""

    link: PlayedLink
    work: SensorWork

    def __init__(self, folder: Path, **settings: Any) -> None:
        super().__init__(folder, **settings)
        self.weather = WeatherBoard(self.clock, self.authorize, FARM)
        self.seq = 0
        self._room = self._made_room()

    async def begin(self) -> None:
        """Draw a parcel, store a mission on it and begin to listen."""
        await self.open()
        records, now = self.records, self.clock.utc()
        geometry = {"type": "Polygon", "coordinates": [RING]}
        await records.database.run(records.features.put, [Feature(PARCEL, FARM, "parcel", "North", geometry)])
        mission = Mission(MISSION, FARM, "Wheat 1", "North", MissionStatus.VALIDATED, "a" * 64, "x", now, now,
                          robot_id=WEEDER, field_id=PARCEL)  # fmt: skip
        if not records.missions.all_known(FARM):
            await records.database.run(records.missions.add, mission, _document())
        await self._load()

    async def end(self) -> None:
        """End everything."""
        await self._room.stop()
        await self.close()

    async def restart(self) -> None:
        """The console goes and comes back: only what is on disk is left."""
        await self._room.stop()
        self._room = self._made_room()
        await self._load()

    async def _load(self) -> None:
        self.work = await self._room._loaded()
        await asyncio.sleep(0)

    def _made_room(self) -> SensorRoom:
        def make(on_message: OnMessage, on_link: OnLink, _on_fault: OnFault) -> PlayedLink:
            self.link = PlayedLink(on_message, on_link)
            return self.link

        wiring = SensorWiring(
            self.settings, self.clock, self.records, live_store(self.fleet), self.authorize, self.events.append,
            self.weather, self.desk, make,
        )  # fmt: skip
        return SensorRoom(wiring)

    # ---- what stations say ----

    def about(self, station: str = "soil-03", kind: str = "soil", **parts: Any) -> m.About:
        """Return what a station says of itself."""
        quantities = {
            "soil": [
                ("soil_moisture", "m3/m3", 0.1),
                ("soil_moisture", "m3/m3", 0.3),
                ("soil_temperature", "degC", 0.1),
            ],
            "weather": [("wind_speed", "m/s", None), ("rain_rate", "mm/h", None), ("air_temperature", "degC", None)],
        }.get(kind, [])  # fmt: skip
        told = [m.Quantity(quantity=name, unit=unit, depth_m=msgspec.UNSET if depth is None else depth)
                for name, unit, depth in quantities]  # fmt: skip
        given: dict[str, Any] = {
            "name": station.replace("-0", " ").capitalize(), "lat_deg": 52.005, "lon_deg": 5.005, "period_s": 60.0,
            "parcel": PARCEL, "quantities": told, **parts,
        }  # fmt: skip
        return m.About(station=station, kind=kind, **given)  # type: ignore[arg-type]

    def says(self, message: Any, *, is_retained: bool = False) -> None:
        """Let a station say something, and the console hear it."""
        kind = {m.About: Up.ABOUT, m.Data: Up.DATA, m.Ack: Up.ACK}[type(message)]
        self.hears(topic(message.station, kind), encode(message), is_retained=is_retained)

    def hears(self, text: str, payload: bytes, *, is_retained: bool = False) -> None:
        """Let any bytes arrive."""
        self.link.deliver(text, payload, is_retained=is_retained)
        self.work.link.drain()

    def measures(
        self, station: str = "soil-03", *, at: datetime | None = None, seq: int | None = None, boot: str = BOOT,
        battery: float | None = None, **values: float,
    ) -> None:  # fmt: skip
        """Let a station measure; ``soil_moisture_10=0.2`` is at 10 cm."""
        self.seq = self.seq + 1 if seq is None else seq
        readings = []
        for name, value in values.items():
            quantity, _, depth = name.rpartition("_")
            has_depth = depth.isdigit()
            readings.append(
                m.Reading(quantity=quantity if has_depth else name, value=value,
                          depth_m=int(depth) / 100 if has_depth else msgspec.UNSET)
            )  # fmt: skip
        self.says(
            m.Data(station=station, boot=boot, seq=self.seq, utc=at or self.clock.utc(), values=readings,
                   battery=msgspec.UNSET if battery is None else battery)
        )  # fmt: skip

    async def accepted(self, station: str = "soil-03", kind: str = "soil", **parts: Any) -> None:
        """Let a station announce itself and somebody take it in."""
        self.says(self.about(station, kind, **parts), is_retained=True)
        await self.work.book.accept(self.person(Role.PLANNER), station, StationWish())

    # ---- what stations are told ----

    def told(self, kind: Down, station: str = "soil-03") -> list[Any]:
        """Return what a station was told, oldest first; ``None`` where a notice was taken away."""
        type_of = {Down.NOTICE: m.Notice, Down.TRIGGER: m.Trigger}[kind]
        return [
            msgspec.json.decode(payload, type=type_of) if payload else None
            for address, payload, _qos, _retain in self.link.published
            if address == Address(station, kind)
        ]

    def answers(self, ref: str, station: str = "soil-03", outcome: str = "accepted", text: str = "Heard.") -> None:
        """Let a station answer."""
        self.says(m.Ack(station=station, id=ref, outcome=outcome, text=text))  # type: ignore[arg-type]

    # ---- the weeder ----

    def weeder(self, status: OrderStatus | None, place: tuple[float, float] = INSIDE) -> None:
        """Let the weeder be somewhere with its mission, or without one."""
        order = None if status is None else order_of(MISSION, "a" * 64, status)
        self.fleet.report(WEEDER, order, self.clock.mono_s())
        self.fleet.place(WEEDER, *place)

    async def passes(self, seconds: float, step_s: float = 5.0) -> None:
        """Let time pass; the console looks every few seconds."""
        left = seconds
        while left > 0:
            self.clock.advance(min(step_s, left))
            left -= step_s
            await self.work.round()

    # ---- screens ----

    def _made(self) -> FastAPI:
        app = FastAPI()
        app.state.access = Access(self, NoTokens(), self.authorize)
        app.include_router(self._room.routes())
        errors.install(app)
        return app

    def shown(self, station: str = "soil-03", role: Role = Role.VIEWER) -> dict[str, Any]:
        """Return what a screen shows of a station."""
        whole = self.work.view.whole(self.person(role))
        return next(one for one in whole["stations"] if one["id"] == station)


@cache
def _document() -> dict[str, Any]:
    """Return a mission's document, planned once."""
    return dict(plan_mission(wish()).document)
