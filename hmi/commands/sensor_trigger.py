"""Asks a camera station for a picture now, and says how it went: accepted, rejected, or no answer."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass

from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.ports import AuditSink
from hmi.domain.ids import new_id
from hmi.domain.role import Permission
from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.order import StationSender, TriggerOrder
from hmi.domain.sensors.station import PICTURES_A_DAY, FieldStation, StationAnswer
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo

TTL_S = 10.0
ANSWER_S = 12.0  # the order's life and the way back
ACCEPTED, REJECTED, TIMED_OUT = "accepted", "rejected", "timed_out"


@dataclass(frozen=True, slots=True)
class Triggered:
    """How it went; ``text`` is a sentence for a person."""

    outcome: str
    text: str


class SensorTrigger:
    """Sends triggers; ``answered`` is told of every answer of a station."""

    def __init__(
        self, sender: StationSender, clock: Clock, authorize: Authorize, audit: AuditSink, *, answer_s: float = ANSWER_S
    ) -> None:
        self._sender, self._clock, self._authorize, self._audit = sender, clock, authorize, audit
        self._answer_s = answer_s
        self._waiting: dict[tuple[str, str], asyncio.Future[StationAnswer]] = {}

    async def send(self, session: SessionInfo, station: FieldStation) -> Triggered:
        """Ask for a picture and wait for the answer; raises ``NotSignedIn`` and ``NotAllowed``."""
        self._authorize(session, Permission.TRIGGER_SENSOR)
        found = self._refused(station) or await self._ask(station)
        self._audit.append(audit_line(session, "sensor", found.outcome, f"Picture: {found.text}", ref=station.id))
        return found

    def answered(self, answer: StationAnswer) -> None:
        """Take an answer; one that nobody waits for is not ours."""
        waiting = self._waiting.get((answer.station_id, answer.ref))
        if waiting is not None and not waiting.done():
            waiting.set_result(answer)

    def _refused(self, station: FieldStation) -> Triggered | None:
        if station.kind is not SensorKind.CAMERA:
            return Triggered(REJECTED, f"{station.name} has no camera.")
        if not station.is_accepted:
            return Triggered(REJECTED, f"{station.name} is new here. Accept it first.")
        if station.pictures_on(self._clock.utc().date().isoformat()) >= PICTURES_A_DAY:
            return Triggered(REJECTED, f"{station.name} has sent its {PICTURES_A_DAY} pictures of today.")
        if any(station_id == station.id for station_id, _ in self._waiting):
            return Triggered(REJECTED, f"{station.name} is asked already. Wait for its answer.")
        return None

    async def _ask(self, station: FieldStation) -> Triggered:
        order = TriggerOrder(station.id, new_id(), self._clock.utc(), TTL_S)
        key = station.id, order.ref
        waiting = self._waiting[key] = asyncio.get_running_loop().create_future()
        try:
            if not self._sender.send(order):
                return Triggered(REJECTED, "No link to the broker. Nothing was sent.")
            answer = await asyncio.wait_for(waiting, self._answer_s)
        except TimeoutError:
            return Triggered(TIMED_OUT, f"{station.name} did not answer. It may have taken a picture all the same.")
        finally:
            del self._waiting[key]
        return Triggered(ACCEPTED if answer.is_accepted else REJECTED, answer.text)
