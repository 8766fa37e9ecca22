"""Missions through the cloud: put as an entity, picked up by the robot's agent, answered with the hash it stored."""

from __future__ import annotations

import asyncio
import logging
import uuid
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

import msgspec

from backend_clients.cloud_robot.mission_answer import MissionAnswer, read_answer
from backend_clients.cloud_robot.mission_order import MissionOrder
from backend_clients.cloud_robot.names import ANSWER, ORDER, answer_ref, order_ref, prefix, presence_ref
from backend_clients.cloud_robot.presence import read_presence
from backend_clients.ngsi.client import NgsiClient
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import BadInput, NgsiError, NotFound, TooLarge, Unreadable
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.query import Query
from hmi.clock import Clock
from hmi.cloud.delays import Delays
from hmi.cloud.map_subscription import IsOurs
from hmi.domain.command import Acknowledgement, OrderFailed
from hmi.domain.mission_document import canonical, mission_sha256

TTL_S = 20.0  # agents ask once a second, brokers answer in well under one; older than this it was decided long ago
ANSWER_S = 25.0  # a little longer than the order lives: after it the robot takes nothing any more
POLL_S = 0.5
AWAY_S = 2.0  # a broker that is back answers sooner; a person waits no longer for one that is known to be away
TIDY_S = 60.0  # until then an agent that was cut off may still answer
Sleep = Callable[[float], Awaitable[None]]
WHY = "Admin, Cloud says why."  # whoever sends is seldom who can mend a broker
log = logging.getLogger(__name__)


class CloudMissions:
    """Sends missions by one broker. The sender knows nothing of robots' addresses: an agent asks by itself.

    Args:
        client: to the broker, without retries: a late order would be worse than none.
        farm: as in the names of the farm's entities.
        delays: of missions that were read back.
        sleep: test seam.
        is_ours: whether the tenant that answers now is ours; in another one a robot of the same name may listen.
        is_away: whether the broker failed when it was last asked; it gets ``AWAY_S`` to show that it is back.
    """

    def __init__(
        self,
        client: NgsiClient,
        farm: str,
        clock: Clock,
        delays: Delays,
        sleep: Sleep = asyncio.sleep,
        *,
        is_ours: IsOurs,
        is_away: Callable[[], bool] = lambda: False,
    ) -> None:
        self._client, self._farm, self._clock, self._delays, self._sleep = client, farm, clock, delays, sleep
        self._is_ours, self._is_away = is_ours, is_away
        self._waited_for: set[EntityRef] = set()
        self._tidy_s = float("-inf")  # an earlier run may have ended while it waited

    async def upload_mission(self, robot_id: str, document: dict[str, Any]) -> Acknowledgement:
        """Store a mission on the robot and return its answer with the hash it read back; see ``OrderSender``.

        Raises:
            OrderFailed: nothing usable came back.
        """
        order = self._order(robot_id, document, await self._challenge(robot_id))
        begin_s, refs = self._clock.mono_s(), self._refs(order)
        self._waited_for.update(refs)
        try:
            await self._put(order)
            answer = await self._answer(order, begin_s)
        finally:
            self._waited_for.difference_update(refs)
            await asyncio.shield(self._withdraw(order))
        delay_s = self._clock.mono_s() - begin_s
        if answer.is_accepted:
            self._delays.add(delay_s)
        if answer.is_accepted and answer.sha256 != order.sha256:
            text = "The robot stored something else than was sent. Send it again."
            return Acknowledgement(robot_id, "mission", order.mission_id, False, "hash_mismatch", text, None,
                                   answer.sha256, None)  # fmt: skip
        return Acknowledgement(
            robot_id, "mission", order.mission_id, answer.is_accepted, answer.code, answer.text, None,
            answer.sha256 or None, None,
        )  # fmt: skip

    async def tidy(self) -> None:
        """Delete orders and answers nobody waits for, if some may have been left behind; raises ``NgsiError``."""
        if self._clock.mono_s() < self._tidy_s:
            return
        self._tidy_s = self._clock.mono_s() + TIDY_S
        left = []
        for kind in (ORDER, ANSWER):
            ours = Query(types=(kind,), id_pattern=f"^{prefix(kind, self._farm)}", attrs=("commandTime",))
            left += [one.ref async for one in self._client.entities(ours)]
        gone = [ref for ref in left if ref not in self._waited_for]
        outcome = await self._client.batch("delete", [Entity(ref=ref) for ref in gone])
        lost = [error for error in outcome.failed.values() if not isinstance(error, NotFound)]
        if lost:
            raise lost[0]
        self._tidy_s = float("inf")

    async def _challenge(self, robot_id: str) -> str:
        """Return the robot's newest challenge; only reads, so it can be given up at any moment."""
        try:
            async with asyncio.timeout(AWAY_S if self._is_away() else None):
                return await self._ask_challenge(robot_id)
        except NgsiError as error:
            log.info("mission by the cloud: %s", error)
            raise _away() from error
        except TimeoutError as late:
            log.info("mission by the cloud: it was away, and did not answer in %g s either", AWAY_S)
            raise _away() from late

    async def _ask_challenge(self, robot_id: str) -> str:
        if not await self._is_ours():
            text = "The tenant in the cloud is not ours now: nothing was sent. Send the mission directly."
            raise OrderFailed("cloud_not_ours", text, is_outcome_known=True)
        found = await self._client.find(presence_ref(self._farm, robot_id))
        if found is None:
            text = "The robot has no way to the cloud. Send it directly."
            raise OrderFailed("no_agent", text, is_outcome_known=True)
        return read_presence(found, robot_id).challenge

    def _order(self, robot_id: str, document: Mapping[str, Any], challenge: str) -> MissionOrder:
        plain = canonical({**document, "robot": robot_id})
        ends = [segment["points"][-1] for segment in plain["segments"]]
        begin = plain["segments"][0]["points"][:1] if plain["segments"] else []
        return MissionOrder(
            robot=robot_id,
            order_id=uuid.uuid4().hex,
            mission_id=plain["mission_id"],
            revision=plain["revision"],
            sha256=mission_sha256(plain),
            challenge=challenge,
            ttl_s=TTL_S,
            at=self._clock.utc(),
            document=msgspec.json.encode(plain),
            waypoints=tuple((point[0], point[1]) for point in [*begin, *ends]),
        )

    async def _put(self, order: MissionOrder) -> None:
        try:
            await self._client.create(order.to_entity(self._farm))
        except (BadInput, TooLarge) as error:
            text = "The mission is too large for the way through the cloud. Send it directly."
            raise OrderFailed("too_large", text, is_outcome_known=True) from error
        except NgsiError as error:
            log.info("mission by the cloud: %s", error)
            if error.is_outcome_unknown:
                text = "The cloud did not answer. The robot may get the mission all the same; it does not move by it."
                raise OrderFailed("cloud_silent", text, is_outcome_known=False) from error
            text = f"The cloud did not take the mission. Send it directly. {WHY}"
            raise OrderFailed("cloud_refused", text, is_outcome_known=True) from error

    async def _answer(self, order: MissionOrder, begin_s: float) -> MissionAnswer:
        ref = answer_ref(self._farm, order.robot, order.order_id)
        while self._clock.mono_s() - begin_s < ANSWER_S:
            await self._sleep(POLL_S)
            try:
                found = await self._client.find(ref)
            except NgsiError as error:
                log.info("mission by the cloud: %s", error)  # asked again until the order is too old
                continue
            if found is not None:
                return _read(found)
        text = (
            "The robot's answer did not come through the cloud in time. Should it have the mission, it does not move "
            "by it; it takes nothing of this order any more. Look what it holds, or send it directly."
        )
        self._left_behind()  # an answer that comes later
        raise OrderFailed("no_answer", text, is_outcome_known=False)

    async def _withdraw(self, order: MissionOrder) -> None:
        """Take order and answer away, both at once: somebody waits. What cannot be deleted grows too old by itself."""
        await asyncio.gather(*map(self._delete, self._refs(order)))

    async def _delete(self, ref: EntityRef) -> None:
        try:
            await self._client.delete(ref)
        except NotFound:
            return
        except NgsiError as error:
            log.info("mission by the cloud: %s is left behind: %s", ref.id, error)
            self._left_behind()

    def _left_behind(self) -> None:
        self._tidy_s = min(self._tidy_s, self._clock.mono_s() + TIDY_S)

    def _refs(self, order: MissionOrder) -> tuple[EntityRef, EntityRef]:
        names = self._farm, order.robot, order.order_id
        return order_ref(*names), answer_ref(*names)


def _away() -> OrderFailed:
    text = f"The cloud does not answer, so nothing was sent. Send the mission directly. {WHY}"
    return OrderFailed("cloud_away", text, is_outcome_known=True)


def _read(entity: Entity) -> MissionAnswer:
    try:
        return read_answer(entity)
    except Unreadable as error:
        text = "What came back through the cloud cannot be read. Send it directly."
        raise OrderFailed("bad_answer", text, is_outcome_known=False) from error
