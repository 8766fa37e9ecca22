"""The robots' cloud agents: take missions from a context broker and put the answers there."""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections import OrderedDict, deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from backend_clients.cloud_robot.mission_answer import MissionAnswer
from backend_clients.cloud_robot.mission_order import MissionOrder, read_order
from backend_clients.cloud_robot.names import ORDER, prefix
from backend_clients.cloud_robot.presence import CHALLENGE_LIFE_S, EVERY_S, Presence
from backend_clients.edge import codec
from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Address, Down
from backend_clients.errors import WireError
from backend_clients.http.retry import RetryPolicy
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.connection import Broker
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import NgsiError, Unreadable
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.query import Query
from backend_clients.ngsi.tenant import Tenant
from backend_clients.simulator.config import CloudConfig
from backend_clients.simulator.verdict import refused
from hmi.clock import Clock

POLL_S = 1.0
AWAY_S = 5.0
REMEMBERED = 500
OnAck = Callable[[str, up.Ack], None]
log = logging.getLogger(__name__)


class Robot(Protocol):
    """What an agent needs of its robot."""

    @property
    def is_reachable(self) -> bool:
        """Whether its software runs and has a network."""
        ...

    def receive(self, order: down.Order, *, is_retained: bool = False) -> up.Ack | None:
        """Judge and carry out an order."""
        ...


@dataclass(slots=True)
class _Agent:
    """One robot's side: challenges it issued, newest last, and orders it has answered."""

    challenges: deque[tuple[float, str]] = field(default_factory=deque)
    answered: OrderedDict[str, MissionAnswer] = field(default_factory=OrderedDict)


class CloudAgents:
    """The agents of all robots of one simulator; one asks for all of them, since they share a broker.

    Args:
        client: to the broker.
        farm: whose robots they are.
        robots: id -> robot.
        on_ack: told of each mission that was judged, so that the robot's own link reports it too.
    """

    def __init__(self, client: NgsiClient, farm: str, robots: dict[str, Robot], clock: Clock, on_ack: OnAck) -> None:
        self._client, self._farm, self._robots, self._clock, self._on_ack = client, farm, robots, clock, on_ack
        self._agents = {robot_id: _Agent() for robot_id in robots}
        self._told: OrderedDict[EntityRef, None] = OrderedDict()  # orders whose answer the broker has
        self._said_s = float("-inf")
        self._is_away = False

    async def run(self) -> None:
        """Work until cancelled; a broker that is away is tried again."""
        try:
            while True:
                is_well = await self._try()
                await asyncio.sleep(POLL_S if is_well else AWAY_S)
        finally:
            await self._client.close()

    async def round(self) -> None:
        """Say that the agents are there, if it is time, and take what waits; raises ``NgsiError``."""
        if self._clock.mono_s() - self._said_s >= EVERY_S:
            await self._say()
        ours = Query(types=(ORDER,), id_pattern=f"^{prefix(ORDER, self._farm)}")
        orders = [one async for one in self._client.entities(ours) if one.ref not in self._told]
        answers = {one.ref: answer for one in orders if (answer := self._answer(one)) is not None}
        if not answers:
            return
        entities = {ref: answer.to_entity(self._farm) for ref, answer in answers.items()}
        outcome = await self._client.batch("append", list(entities.values()))
        arrived = set(outcome.done)
        self._told.update(dict.fromkeys(ref for ref, entity in entities.items() if entity.ref in arrived))
        while len(self._told) > REMEMBERED:
            self._told.popitem(last=False)

    async def _try(self) -> bool:
        try:
            await self.round()
        except NgsiError as error:
            if not self._is_away:
                log.info("cloud agents: %s", error)
            self._is_away = True
            return False
        self._is_away = False
        return True

    async def _say(self) -> None:
        now_s, entities = self._clock.mono_s(), []
        for robot_id, agent in self._agents.items():
            if self._robots[robot_id].is_reachable:
                challenge = secrets.token_urlsafe(12)
                agent.challenges.append((now_s, challenge))
                entities.append(Presence(robot_id, challenge, self._clock.utc()).to_entity(self._farm))
            while agent.challenges and now_s - agent.challenges[0][0] > CHALLENGE_LIFE_S:
                agent.challenges.popleft()
        outcome = await self._client.batch("append", entities) if entities else None
        if outcome is not None and outcome.failed:
            raise next(iter(outcome.failed.values()))
        self._said_s = now_s

    def _answer(self, entity: Entity) -> MissionAnswer | None:
        """Judge one order; ``None`` if it is not for us, or nobody can say to whom the answer goes."""
        try:
            order = read_order(entity)
        except Unreadable as error:
            log.info("cloud agents: %s", error)
            return None
        robot, agent = self._robots.get(order.robot), self._agents.get(order.robot)
        if robot is None or agent is None or not robot.is_reachable:
            return None
        if order.order_id not in agent.answered:
            agent.answered[order.order_id] = self._judged(order, robot, agent)
            while len(agent.answered) > REMEMBERED:
                agent.answered.popitem(last=False)
        return agent.answered[order.order_id]  # the same order again: the same answer, no second effect

    def _judged(self, order: MissionOrder, robot: Robot, agent: _Agent) -> MissionAnswer:
        code = _too_late(order, agent, self._clock.mono_s())
        if code:
            return self._refusal(order, code, refused(code).text)
        try:
            mission = codec.decode_body(Address(order.robot, Down.MISSION), order.document)
        except WireError as error:
            return self._refusal(order, "bad_mission", f"{error}"[:300])
        assert isinstance(mission, down.Mission)
        ack = robot.receive(mission)
        if ack is None:
            return self._refusal(order, "off", "The robot is switched off.")
        self._on_ack(order.robot, ack)
        sha256 = ack.sha256 if isinstance(ack.sha256, str) else ""
        is_accepted, now = ack.outcome == "accepted", self._clock.utc()
        return MissionAnswer.to(
            order, is_accepted=is_accepted, code=ack.code, text=ack.text, sha256=sha256, received_at=now
        )

    def _refusal(self, order: MissionOrder, code: str, text: str) -> MissionAnswer:
        now = self._clock.utc()
        return MissionAnswer.to(order, is_accepted=False, code=code, text=text, sha256="", received_at=now)


def agents_of(cloud: CloudConfig, robots: dict[str, Robot], clock: Clock, on_ack: OnAck) -> CloudAgents:
    """Return the agents of robots at the broker of a configuration."""
    broker = Broker(cloud.url, Tenant(cloud.tenant, cloud.path), timeout_s=5.0, retry=RetryPolicy(attempts=1))
    return CloudAgents(NgsiClient(broker), cloud.farm, robots, clock, on_ack)


def _too_late(order: MissionOrder, agent: _Agent, now_s: float) -> str:
    """Return why an order is refused for its age, empty if it is fresh; no wall clock takes part."""
    issued_s = next((at_s for at_s, known in agent.challenges if known == order.challenge), None)
    if issued_s is None or now_s - issued_s > CHALLENGE_LIFE_S:
        return "stale_challenge"
    return "expired" if now_s - issued_s > order.ttl_s else ""
