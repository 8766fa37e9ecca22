"""Sending a stored mission to a robot: uploaded, read back, compared. It moves nothing."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, Protocol

from hmi.commands.audit_line import audit_line
from hmi.commands.gate import Gate
from hmi.commands.ports import AuditSink, LaneEvent, MissionSource, MissionStore, StoredMission
from hmi.commands.refusal import BUSY, HAS_PROGRESS, HASH_MISMATCH, NO_CLOUD, NO_REVERSE, UNKNOWN_MISSION, OrderRefused
from hmi.domain.command import Acknowledgement, OrderFailed, OrderSender, Outcome
from hmi.domain.mission_document import drives_backward
from hmi.domain.robot import Robot
from hmi.domain.role import Permission
from hmi.security.session_info import SessionInfo
from hmi.store.errors import StoreError

Proof = Callable[[], Mapping[str, Any]]
log = logging.getLogger(__name__)


class Way(StrEnum):
    """How a mission goes to a robot."""

    DIRECT = "direct"
    CLOUD = "cloud"


class MissionWay(Protocol):
    """Uploads a mission by one way; see ``OrderSender``."""

    async def upload_mission(self, robot_id: str, document: dict[str, Any]) -> Acknowledgement:
        """Store a mission on the robot and return its answer; raises ``OrderFailed``."""
        ...


@dataclass(frozen=True, slots=True)
class MissionSent:
    """What became of sending; ``sha256`` is the hash the robot read back, if it did, ``took_s`` how long that took."""

    outcome: Outcome
    code: str
    text: str
    sha256: str | None = None
    way: Way = Way.DIRECT
    took_s: float | None = None


class MissionSender:
    """Uploads missions, one at a time and robot. ``cloud`` is the second way, set once there is a cloud."""

    def __init__(
        self, gate: Gate, source: MissionStore, sender: OrderSender, audit: AuditSink, on_event: LaneEvent
    ) -> None:
        self._gate, self._source, self._sender = gate, source, sender
        self._audit, self._on_event = audit, on_event
        self.cloud: MissionWay | None = None
        self._busy: set[str] = set()
        self._listeners: list[Callable[[str], None]] = []

    def on_sent(self, callback: Callable[[str], None]) -> None:
        """Call ``callback`` with the id of each robot that has read a mission back."""
        self._listeners.append(callback)

    async def send(
        self, actor: SessionInfo, robot_id: str, mission_id: str, *, is_fresh: bool = False, way: Way = Way.DIRECT
    ) -> MissionSent:
        """Send a stored mission; only a robot that read back the same hash has it.

        Args:
            way: never changed by itself: a mission that does not get through by one way was not sent by the other.
            is_fresh: whoever sends knows that interrupted work is forgotten; else it is refused with ``has_progress``.
        """
        source = self._source if is_fresh else _Careful(self._source)
        return await self.put(actor, robot_id, mission_id, source, way=way)

    async def put(
        self,
        actor: SessionInfo,
        robot_id: str,
        mission_id: str,
        source: MissionSource,
        proof: Proof | None = None,
        way: Way = Way.DIRECT,
    ) -> MissionSent:
        """Send what ``source`` has for this mission and robot, as ``send`` does.

        Args:
            proof: asked in the moment of sending that the person has control and decided just now, for a robot that
                drives; raises ``OrderRefused``.
        """
        try:
            robot = self._gate.right(actor, Permission.SEND_MISSION, robot_id)
            if robot_id in self._busy:
                raise OrderRefused(BUSY, f"{robot.name} is getting a mission already.")
        except OrderRefused as refused:
            return self._settle(actor, robot_id, mission_id, MissionSent(Outcome.REJECTED, refused.code, refused.text))
        self._busy.add(robot_id)
        try:
            begin_s = asyncio.get_running_loop().time()
            sent = await self._upload(actor, robot, mission_id, source, proof, way)
            took_s = asyncio.get_running_loop().time() - begin_s
            text = sent.text
            if way is Way.CLOUD and sent.outcome is Outcome.ACCEPTED:
                text = f"{text} It went through the cloud in {took_s:.1f} s."
            sent = replace(sent, text=text, way=way, took_s=round(took_s, 2))
            return self._settle(actor, robot_id, mission_id, sent)
        finally:
            self._busy.discard(robot_id)

    async def _upload(
        self, actor: SessionInfo, robot: Robot, mission_id: str, source: MissionSource, proof: Proof | None, way: Way
    ) -> MissionSent:
        try:
            stored = await source.stored(actor.farm_id, mission_id, robot.id, actor.user_name)
        except OrderRefused as refused:
            return MissionSent(Outcome.REJECTED, refused.code, refused.text)
        if stored is None:
            return MissionSent(Outcome.REJECTED, UNKNOWN_MISSION, "There is no such mission.")
        sent = await self._bring(robot, stored, proof, way)
        by = actor.user_name
        try:
            if sent.outcome is Outcome.ACCEPTED:
                await source.sent(actor.farm_id, mission_id, robot.id, by)
            elif sent.outcome is Outcome.REJECTED:
                await self._source.refused(actor.farm_id, mission_id, stored.sha256, by, sent.text)
        except StoreError:  # what the robot has does not change by that, and its state will say so
            log.exception("what became of mission %s on %s was not stored", mission_id, robot.id)
        if sent.outcome is Outcome.ACCEPTED:
            for listener in self._listeners:
                listener(robot.id)
        return sent

    async def _bring(self, robot: Robot, stored: StoredMission, proof: Proof | None, way: Way) -> MissionSent:
        """Upload one document and compare what the robot read back."""
        try:
            _check_fits(robot, stored)
            document = {**stored.document, **({} if proof is None else {"proof": proof()})}
            answer = await self._by(way).upload_mission(robot.id, document)
        except OrderRefused as refused:
            return MissionSent(Outcome.REJECTED, refused.code, refused.text)
        except OrderFailed as failed:
            outcome = Outcome.REJECTED if failed.is_outcome_known else Outcome.UNKNOWN
            return MissionSent(outcome, failed.code, failed.text)
        if not answer.is_accepted:
            return MissionSent(Outcome.REJECTED, answer.code, answer.text, answer.sha256)
        if answer.sha256 != stored.sha256:
            text = f"{robot.name} read back another mission than was sent. Do not start it; send it again."
            return MissionSent(Outcome.REJECTED, HASH_MISMATCH, text, answer.sha256)
        text = " ".join(filter(None, (_sent_text(robot, stored), stored.note)))
        return MissionSent(Outcome.ACCEPTED, "ok", text, answer.sha256)

    def _by(self, way: Way) -> MissionWay:
        if way is Way.DIRECT:
            return self._sender
        if self.cloud is None:
            raise OrderRefused(NO_CLOUD, "This console has no cloud. Send the mission directly.")
        return self.cloud

    def _settle(self, actor: SessionInfo, robot_id: str, mission_id: str, result: MissionSent) -> MissionSent:
        data: dict[str, Any] = {"mission_id": mission_id, "code": result.code, "sha256": result.sha256}
        data |= {"way": result.way.value, "took_s": result.took_s}
        self._audit.append(
            audit_line(
                actor, "mission", result.outcome.value, result.text, ref=mission_id, robot_id=robot_id, data=data
            )
        )
        event = {"kind": "mission", "robot": robot_id, "outcome": result.outcome.value, "text": result.text}
        self._on_event({**event, **data, "by": actor.user_name})
        return result


class _Careful:
    """Gives no mission away whose interrupted work would be forgotten."""

    def __init__(self, source: MissionStore) -> None:
        self._source = source
        self.sent = source.sent

    async def stored(self, farm_id: str, mission_id: str, robot_id: str, by: str) -> StoredMission | None:
        """Return the mission; raises ``OrderRefused`` as its source, and for interrupted work."""
        forgotten = self._source.forgets(farm_id, mission_id)
        if forgotten:
            text = (
                f"It was interrupted: {forgotten}. Resume it, resume it later, or start it fresh, which forgets that."
            )
            raise OrderRefused(HAS_PROGRESS, text)
        return await self._source.stored(farm_id, mission_id, robot_id, by)


def _check_fits(robot: Robot, stored: StoredMission) -> None:
    """Refuse what the robot would refuse, in words that say the way out."""
    sheet = robot.factsheet
    if sheet is not None and sheet.path_reverse_mps is None and drives_backward(stored.document):
        text = f"{robot.name} follows no path backwards, and this one does in its turns. Plan the mission for it."
        raise OrderRefused(NO_REVERSE, text)


def _sent_text(robot: Robot, stored: StoredMission) -> str:
    return f"{robot.name} has {stored.name} and read it back. Sending does not move the robot."
