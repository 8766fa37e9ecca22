"""Who is responsible for which robot: take, give back, hand over to somebody who takes it over, and the shift book.

A hand-over is an offer. Until the other person takes it, the one who gives stays responsible: no robot is ever
nobody's because somebody looked away. Who may not operate any more answers for nothing: their robots are nobody's.
Responsibility is not control: it moves nothing and needs no lease.
"""

from __future__ import annotations

import asyncio
import logging
from collections import defaultdict
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

from hmi.clock import Clock
from hmi.commands.ports import AuditSink, LaneEvent
from hmi.commands.refusal import OrderRefused
from hmi.domain.role import Permission, may
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.duty import Duties, Duty, HandOver
from hmi.store.errors import StoreError
from hmi.store.users import User

NOT_YOURS, NOBODY, NOT_OFFERED, NOT_OPERATOR = "not_yours", "nobody", "not_offered", "not_operator"
CONSOLE_NAME = "Headland"  # who writes in the shift book what no person did
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Responsible:
    """The person who answers for a robot."""

    user_id: str
    user_name: str


@dataclass(frozen=True, slots=True)
class DutyParts:
    """What the desk is wired to.

    Args:
        people: the farm's people, from the database; blocks.
        is_robot: whether a robot is registered now.
        name_of: what people call a robot.
    """

    duties: Duties
    database: Database
    people: Callable[[str], list[User]]
    farm_id: str
    is_robot: Callable[[str], bool]
    name_of: Callable[[str], str]
    audit: AuditSink
    authorize: Authorize
    clock: Clock
    on_event: LaneEvent


class DutyDesk:
    """Raises (every method with a session): ``NotSignedIn``, ``NotAllowed``, ``OrderRefused``, ``StoreError``.

    One change after another: what a change goes by, duties and who may operate, is so until it is written.
    """

    def __init__(self, parts: DutyParts) -> None:
        self._parts = parts
        self._changing = asyncio.Lock()

    def responsible_for(self, robot_id: str) -> Responsible | None:
        """Return who answers for a robot, ``None`` if nobody does; from memory."""
        duty = self._parts.duties.of(robot_id)
        return Responsible(duty.user_id, duty.user_name) if duty.user_id else None

    def all(self, session: SessionInfo) -> list[Duty]:
        """Return every duty and offer."""
        self._parts.authorize(session, Permission.WATCH)
        return self._parts.duties.all()

    def freed(self, session: SessionInfo) -> list[Duty]:
        """Return robots that lost who was responsible for them; ``since`` is when."""
        self._parts.authorize(session, Permission.WATCH)
        return [one for one in self._parts.duties.freed() if self._parts.is_robot(one.robot_id)]

    async def book(self, session: SessionInfo) -> list[HandOver]:
        """Return the newest lines of the shift book."""
        self._parts.authorize(session, Permission.WATCH)
        return await self._parts.database.run(self._parts.duties.book)

    async def people(self, session: SessionInfo) -> list[User]:
        """Return who may be made responsible: active people who may operate."""
        self._parts.authorize(session, Permission.WATCH)
        return await self._operators()

    async def take(self, session: SessionInfo, robots: Sequence[str], note: str = "") -> list[Duty]:
        """Become responsible for robots that are nobody's; a supervisor may take anybody's."""
        async with self._changing:
            return await self._take(session, robots, note)

    async def _take(self, session: SessionInfo, robots: Sequence[str], note: str) -> list[Duty]:
        self._refuse_foreign(session, robots)
        await self._refuse_former(session)
        now = self._parts.clock.utc()
        mine = [Duty(robot_id, session.user_id, session.user_name, now, note) for robot_id in robots]
        return await self._write(session, mine, "taken", session.user_name, note)

    async def release(self, session: SessionInfo, robots: Sequence[str], note: str = "") -> list[Duty]:
        """Be responsible no longer; they are nobody's then, and the screen says so."""
        async with self._changing:
            self._refuse_foreign(session, robots)
            now, duties = self._parts.clock.utc(), [self._parts.duties.of(one) for one in robots]
            # what is nobody's already stays so since when it was: pressed twice, supervisors are told all the same
            freed = [Duty(one.robot_id, since=now if one.user_id else one.since, note=note) for one in duties]
            return await self._write(session, freed, "released", "", note)

    async def hand_over(self, session: SessionInfo, robots: Sequence[str], to_user: str, note: str) -> list[Duty]:
        """Offer robots to somebody; who gives stays responsible until the other takes them."""
        self._parts.authorize(session, Permission.WATCH)
        async with self._changing:
            to = next((one for one in await self._operators() if one.id == to_user), None)
            if to is None:
                raise OrderRefused(NOBODY, "Nobody of that name may operate robots here.")
            if to.id == session.user_id:
                return await self._take(session, robots, note)
            return await self._offer(session, robots, to, note)

    async def _offer(self, session: SessionInfo, robots: Sequence[str], to: User, note: str) -> list[Duty]:
        self._refuse_foreign(session, robots)
        await self._refuse_former(session)
        now = self._parts.clock.utc()
        offered = [
            replace(
                self._parts.duties.of(robot_id), offered_to=to.id, offered_name=to.name,
                offered_by=session.user_name, offered_by_id=session.user_id, offered_at=now, offered_note=note,
            )
            for robot_id in robots
        ]  # fmt: skip
        return await self._write(session, offered, "offered", to.name, note)

    async def accept(self, session: SessionInfo, robots: Sequence[str]) -> list[Duty]:
        """Take over what was offered to this person."""
        async with self._changing:
            duties = self._offered(session, robots)
            await self._refuse_former(session)
            now = self._parts.clock.utc()
            mine = [Duty(one.robot_id, session.user_id, session.user_name, now, one.offered_note) for one in duties]
            return await self._write(session, mine, "accepted", session.user_name, _first_note(duties))

    async def decline(self, session: SessionInfo, robots: Sequence[str], note: str = "") -> list[Duty]:
        """Leave what was offered with who gave it; who offered it, or is responsible, may withdraw it the same way."""
        async with self._changing:
            duties = [self._parts.duties.of(one) for one in robots]
            is_giver = all(one.offered_to and session.user_id in (one.user_id, one.offered_by_id) for one in duties)
            for one in duties if is_giver else ():
                self._parts.authorize(session, Permission.PAUSE, one.robot_id)
            if not is_giver:
                duties = self._offered(session, robots)
            kept = [_not_offered(one) for one in duties]
            return await self._write(session, kept, "withdrawn" if is_giver else "declined", "", note)

    async def let_go(self, by: str = CONSOLE_NAME, robots: Collection[str] = ()) -> None:
        """Free what people answer for who may not operate any more, take back what is offered to them; also ``robots``.

        ``robots`` were taken out: one of the same name that comes back is nobody's. What cannot be written is logged,
        and done the next time.
        """
        try:
            async with self._changing:
                for (what, note), duties in (await self._to_free(robots)).items():
                    await self._put(by, "", duties, what, "", note)
        except StoreError:
            log.exception("duties of people or robots that are gone could not be freed")

    async def _to_free(self, robots: Collection[str]) -> dict[tuple[str, str], list[Duty]]:
        able = {one.id for one in await self._operators()}
        changes: dict[tuple[str, str], list[Duty]] = defaultdict(list)
        duties = self._parts.duties
        for duty in {one.robot_id: one for one in (*duties.all(), *duties.freed())}.values():
            if duty.robot_id in robots or not self._parts.is_robot(duty.robot_id):
                changes["released", "Taken out of the registry."].append(Duty(duty.robot_id))
                continue
            left = duty if duty.offered_to in able else _not_offered(duty)
            if duty.user_id and duty.user_id not in able:
                left = replace(left, user_id="", user_name="", since=self._parts.clock.utc(), note="")
                changes["released", f"{duty.user_name} does not operate robots here any more."].append(left)
            elif left != duty:
                changes["withdrawn", f"{duty.offered_name} does not operate robots here any more."].append(left)
        return changes

    async def _operators(self) -> list[User]:
        known = await self._parts.database.run(self._parts.people, self._parts.farm_id)
        return [one for one in known if one.is_active and may(one.role, Permission.PAUSE)]

    def _offered(self, session: SessionInfo, robots: Sequence[str]) -> list[Duty]:
        duties = [self._parts.duties.of(one) for one in robots]
        for one in duties:
            self._parts.authorize(session, Permission.PAUSE, one.robot_id)
            if one.offered_to != session.user_id:
                name = self._parts.name_of(one.robot_id)
                raise OrderRefused(NOT_OFFERED, f"{name} is not offered to you any more.")
        return duties

    async def _refuse_former(self, session: SessionInfo) -> None:
        """Refuse who was switched off, or may not operate any more, while the request was under way."""
        if all(one.id != session.user_id for one in await self._operators()):
            raise OrderRefused(NOT_OPERATOR, "You may not operate robots here any more.")

    def _refuse_foreign(self, session: SessionInfo, robots: Sequence[str]) -> None:
        """Refuse robots that are somebody else's, but not a supervisor, or where the right is missing."""
        for robot_id in robots:
            self._parts.authorize(session, Permission.PAUSE, robot_id)
            duty = self._parts.duties.of(robot_id)
            if duty.user_id not in ("", session.user_id) and not may(session.role, Permission.TAKE_LEASE):
                name = self._parts.name_of(robot_id)
                raise OrderRefused(NOT_YOURS, f"{duty.user_name} is responsible for {name}. Ask for a hand-over.")

    async def _write(
        self, session: SessionInfo, duties: Sequence[Duty], what: str, to_name: str, note: str
    ) -> list[Duty]:
        return await self._put(session.user_name, session.device_name, duties, what, to_name, note, session.user_id)

    async def _put(
        self, by: str, device: str, duties: Sequence[Duty], what: str, to_name: str, note: str, by_id: str = ""
    ) -> list[Duty]:
        robots = tuple(one.robot_id for one in duties)
        before = [self._parts.duties.of(one) for one in robots]
        pairs = zip(before, duties, strict=True)
        left = sorted({old.user_id for old, new in pairs if old.user_id not in ("", new.user_id)})
        line = HandOver(self._parts.clock.utc(), what, by, to_name, robots, note)
        await self._parts.database.run(self._parts.duties.write, duties, line)
        names = ", ".join(self._parts.name_of(one) for one in robots[:8])
        text = f"Responsibility {what}{f' ({to_name})' if to_name else ''}: {names}."
        self._parts.audit.append(
            AuditEntry(
                self._parts.farm_id, by, device, "duty", what,
                robots[0] if len(robots) == 1 else None, "", text, {"robots": list(robots), "note": note},
            )
        )  # fmt: skip
        to_user = {"offered": duties[0].offered_to, "declined": before[0].offered_by_id}.get(what, "")
        told = {"what": what, "robots": list(robots), "by": by, "by_id": by_id, "to_user": to_user, "note": note}
        called = [self._parts.name_of(one) for one in robots if self._parts.is_robot(one)]
        self._parts.on_event({"kind": "duty", **told, "from_users": left, "names": called})
        return list(duties)


def _not_offered(duty: Duty) -> Duty:
    return Duty(duty.robot_id, duty.user_id, duty.user_name, duty.since, duty.note)


def _first_note(duties: Sequence[Duty]) -> str:
    return next((one.offered_note for one in duties if one.offered_note), "")
