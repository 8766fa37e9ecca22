"""All simulated stations of a process: one broker connection, one loop that sleeps until something is due."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
from dataclasses import dataclass
from functools import partial
from typing import Any

import structlog

from backend_clients.edge.mqtt import LinkState, MqttLink
from backend_clients.errors import WireError
from backend_clients.field.topics import Down, Up, parse, topic
from backend_clients.simulator.cameras.map_feature import MapFeature
from backend_clients.simulator.cameras.studio import NoPicture
from backend_clients.simulator.field.faults import BY_ID, SITUATIONS, Faults, decode_fault, name_of
from backend_clients.simulator.field.picture import FieldStudio
from backend_clients.simulator.field.session import StationSession
from backend_clients.simulator.field.soil import Ground
from backend_clients.simulator.field.station import StationConfig
from backend_clients.simulator.field.weather import Weather
from backend_clients.simulator.loop_mail import LoopMail
from hmi.clock import Clock, SystemClock

log = structlog.get_logger(__name__)


@dataclass(frozen=True, slots=True)
class YardConfig:
    """The stations of one process.

    Args:
        seed: the same seed is the same weather.
        speed: the weather goes so many times faster.
        features: the farm's map, which cameras show.
        is_always_day: cameras see a summer morning at any hour.
    """

    broker_url: str
    stations: tuple[StationConfig, ...]
    seed: int = 1
    speed: float = 1.0
    features: tuple[MapFeature, ...] = ()
    is_always_day: bool = False

    def __post_init__(self) -> None:
        ids = [one.id for one in self.stations]
        if not ids:
            raise ValueError("there is no station to simulate")
        if len(set(ids)) != len(ids):
            raise ValueError(f"two simulated stations have the same id: {', '.join(sorted(ids))}")


class Yard:
    """Runs stations until cancelled.

    Args:
        clock: the system's unless a test brings its own.
    """

    def __init__(self, config: YardConfig, clock: Clock | None = None) -> None:
        self._config, self._clock = config, clock or SystemClock()
        place = config.stations[0]
        weather = Weather(config.seed, place.lat_deg, place.lon_deg)
        ground = Ground(weather, self._clock.utc().timestamp())
        self._studio = FieldStudio(config.features, is_always_day=config.is_always_day)
        self._drawing: set[asyncio.Task[None]] = set()
        self._wake = asyncio.Event()
        self._link: MqttLink | None = None
        self._situations: dict[str, str] = {}
        self.sessions = {one.id: self._session(one, weather, ground) for one in config.stations}

    async def run(self) -> None:
        """Connect and live until cancelled."""
        mail = LoopMail(asyncio.get_running_loop())
        self._link = MqttLink(
            self._config.broker_url,
            f"field-{secrets.token_hex(4)}",
            subscriptions=[(topic(one, kind), 1) for one in self.sessions for kind in Down],
            on_message=lambda *heard: mail.post(lambda: self._heard(*heard)),
            on_link=lambda state, _text: mail.post(self._greet) if state is LinkState.UP else None,
        )
        self._link.start()
        try:
            while True:
                await self._rest()
                for session in self.sessions.values():
                    session.tick()
        finally:
            for task in self._drawing:
                task.cancel()
            await self._studio.close()
            await asyncio.to_thread(self._link.stop)

    # ---- the tester's doors --------------------------------------------------------------------------

    def told(self) -> dict[str, Any]:
        """Return the stations, what can happen to them and what does; as ``/_situations`` tells of robots."""
        return {
            "stations": [{"id": s.id, "name": s.name, "kind": s.kind} for s in self._config.stations],
            "situations": [{"id": s.id, "title": s.title, "text": s.text, "families": s.kinds} for s in SITUATIONS],
            "now": {
                one: played
                for one, played in self._situations.items()
                if self._is_on(self.sessions[one].faults, played)
            },
        }  # fmt: skip

    def provoke(self, station_id: str, situation_id: str | None) -> None:
        """Play a situation in place of the one that is on; ``None`` ends it.

        Raises:
            KeyError: there is no such station or situation.
            ValueError: it cannot happen to this station.
        """
        session = self.sessions[station_id]
        situation = BY_ID[situation_id] if situation_id is not None else None
        if situation is not None and session.config.kind not in situation.kinds:
            raise ValueError(f"{situation.title} cannot happen to {session.config.name}")
        before = self._situations.pop(station_id, None)
        if before is not None:
            session.clear_fault(name_of(BY_ID[before].fault))
        if situation is not None:
            self._situations[station_id] = situation.id
            session.set_fault(situation.fault)
        self._wake.set()

    def set_fault(self, station_id: str, payload: bytes) -> None:
        """Switch a fault on; raises ``KeyError``, ``msgspec.DecodeError``."""
        self.sessions[station_id].set_fault(decode_fault(payload))

    def clear_fault(self, station_id: str, name: str | None) -> None:
        """Switch one fault, or all, off; raises ``KeyError``."""
        self.sessions[station_id].clear_fault(name)
        self._wake.set()

    def faults(self, station_id: str) -> dict[str, Any]:
        """Return the active faults by name; raises ``KeyError``."""
        return {name_of(fault): fault for fault in self.sessions[station_id].faults.list()}

    def _is_on(self, faults: Faults, situation_id: str) -> bool:
        return BY_ID[situation_id].fault in faults.list()

    # ---- inside ---------------------------------------------------------------------------------------

    def _session(self, station: StationConfig, weather: Weather, ground: Ground) -> StationSession:
        send, shoot = partial(self._send, station.id), partial(self._shoot, station)
        return StationSession(station, weather, ground, self._clock, send, shoot, speed=self._config.speed)

    async def _rest(self) -> None:
        """Wait until something is due or was heard."""
        due_s = min(session.due_s for session in self.sessions.values())
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(max(due_s - self._clock.mono_s(), 0.01)):
                await self._wake.wait()
        self._wake.clear()

    def _greet(self) -> None:
        for session in self.sessions.values():
            session.greet()
        self._wake.set()

    def _heard(self, name: str, payload: bytes, is_retained: bool) -> None:
        try:
            address = parse(name)
        except WireError:
            return
        session = self.sessions.get(address.station)
        if session is not None and isinstance(address.kind, Down):
            session.hear(address.kind, payload, is_retained=is_retained)
            self._wake.set()

    def _send(self, station_id: str, kind: Up, payload: bytes, qos: int, is_retained: bool) -> bool:
        link = self._link
        return link is not None and link.publish(topic(station_id, kind), payload, qos=qos, retain=is_retained)

    def _shoot(self, station: StationConfig) -> None:
        task = asyncio.get_running_loop().create_task(self._draw(station), name=f"picture-{station.id}")
        self._drawing.add(task)
        task.add_done_callback(self._drawing.discard)

    async def _draw(self, station: StationConfig) -> None:
        try:
            jpeg = await self._studio.picture(station, self._clock.utc())
        except NoPicture as problem:
            log.warning("a field camera took no picture", station=station.id, problem=str(problem))
        else:
            self.sessions[station.id].show(jpeg)
