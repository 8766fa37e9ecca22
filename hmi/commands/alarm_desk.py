"""What people do with alarms: asked for rights, done, and written down. Nothing here resets or moves a machine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from hmi.clock import Clock
from hmi.commands.ports import AuditSink
from hmi.domain.alarm.life import AlarmRefused
from hmi.domain.alarm.live_alarm import LiveAlarm
from hmi.domain.role import Permission, may
from hmi.security.authorization import Authorize
from hmi.security.errors import NotAllowed
from hmi.security.session_info import SessionInfo
from hmi.store.alarms import AlarmStore, Person
from hmi.store.audit_chain import AuditEntry
from hmi.store.errors import NotFound

SHELF_MINUTES = (15, 60, 240)


@dataclass(frozen=True, slots=True)
class Verdict:
    """What came of one act on one alarm; ``code`` is ``ok`` or why not."""

    id: str
    code: str
    text: str
    live: LiveAlarm | None = None


class AlarmDesk:
    """Acknowledge, clear, shelve, take out of service.

    Args:
        is_robot: whether a source is a registered robot; others are the console and stations.
        shift_end: when the shift that runs now ends.
    """

    def __init__(
        self,
        store: AlarmStore,
        audit: AuditSink,
        authorize: Authorize,
        clock: Clock,
        is_robot: Callable[[str], bool],
        shift_end: Callable[[], datetime],
    ) -> None:
        self._store, self._audit, self._authorize, self._clock = store, audit, authorize, clock
        self._is_robot, self._shift_end = is_robot, shift_end

    def acknowledge(self, session: SessionInfo, alarm_id: str) -> LiveAlarm:
        """Note that this person has seen it; it stays as long as what raised it.

        Raises:
            NotFound, AlarmRefused, NotSignedIn, NotAllowed.
        """
        before = self._for(session, Permission.ACKNOWLEDGE_ALARM, alarm_id)
        after = self._store.acknowledge(alarm_id, _person(session))
        if after is not before:
            self._note(session, after, "acknowledged")
        return after

    def acknowledge_all(self, session: SessionInfo, alarm_ids: Sequence[str]) -> list[Verdict]:
        """Acknowledge each; one that cannot be says why and does not stop the others.

        Raises:
            NotSignedIn, NotAllowed: this person may acknowledge none.
        """
        self._authorize(session, Permission.ACKNOWLEDGE_ALARM)
        return [self._verdict(session, one) for one in dict.fromkeys(alarm_ids)]

    def clear(self, session: SessionInfo, alarm_id: str) -> LiveAlarm:
        """End one that stayed after its condition was gone; raises as ``acknowledge``.

        One that came and went unseen is acknowledged by it: who clears it has seen it.
        """
        live = self._for(session, Permission.ACKNOWLEDGE_ALARM, alarm_id)
        person = _person(session)
        if live.alarm.needs_seeing and not live.alarm.is_active:
            live = self._store.acknowledge(alarm_id, person)
        if self._store.find(alarm_id) is not None:
            live = self._store.clear(alarm_id, person)
        self._note(session, live, "cleared")
        return live

    def shelve(self, session: SessionInfo, alarm_id: str, reason: str, minutes: int | None) -> LiveAlarm:
        """Put it aside for some minutes, or to the end of the shift (``None``); raises as ``acknowledge``."""
        self._for(session, Permission.SHELVE_ALARM, alarm_id)
        until = self._shift_end() if minutes is None else self._clock.utc() + timedelta(minutes=minutes)
        live = self._store.shelve(alarm_id, _person(session), reason, until)
        self._note(session, live, "shelved", f"until {until.isoformat(timespec='minutes')}: {reason}")
        return live

    def unshelve(self, session: SessionInfo, alarm_id: str) -> LiveAlarm:
        """Bring it back before its time; raises as ``acknowledge``."""
        self._for(session, Permission.SHELVE_ALARM, alarm_id)
        live = self._store.unshelve(alarm_id, _person(session))
        self._note(session, live, "unshelved")
        return live

    def take_out(self, session: SessionInfo, alarm_id: str, reason: str) -> LiveAlarm:
        """Take it out of service until somebody puts it back; raises as ``acknowledge``.

        One of priority 1 is taken out by an admin only; what another took out comes back if it becomes that.
        """
        live = self._for(session, Permission.SHELVE_ALARM, alarm_id)
        if live.priority == 1:
            self._authorize(session, Permission.MANAGE_ALARMS)
        holds_critical = may(session.role, Permission.MANAGE_ALARMS)
        live = self._store.take_out(alarm_id, _person(session), reason, holds_critical=holds_critical)
        self._note(session, live, "out_of_service", reason)
        return live

    def put_back(self, session: SessionInfo, alarm_id: str) -> LiveAlarm:
        """Put it back into service; raises as ``acknowledge``."""
        self._for(session, Permission.SHELVE_ALARM, alarm_id)
        live = self._store.put_back(alarm_id, _person(session))
        self._note(session, live, "in_service")
        return live

    def may_see(self, session: SessionInfo) -> None:
        """Return if this person may read alarms; raises ``NotSignedIn``, ``NotAllowed``."""
        self._authorize(session, Permission.WATCH)

    def _verdict(self, session: SessionInfo, alarm_id: str) -> Verdict:
        try:
            live = self.acknowledge(session, alarm_id)
        except NotFound:
            return Verdict(alarm_id, "not_found", "It is normal again.")
        except (AlarmRefused, NotAllowed) as error:
            return Verdict(alarm_id, error.code, error.text)
        return Verdict(alarm_id, "ok", "", live)

    def _for(self, session: SessionInfo, permission: Permission, alarm_id: str) -> LiveAlarm:
        self._authorize(session, permission)
        live = self._store.get(alarm_id)
        source = live.alarm.key.source
        if self._is_robot(source):
            self._authorize(session, permission, source)
        return live

    def _note(self, session: SessionInfo, live: LiveAlarm, outcome: str, text: str = "") -> None:
        source = live.alarm.key.source
        self._audit.append(
            AuditEntry(
                farm_id=session.farm_id,
                actor=session.user_name,
                device=session.device_name,
                kind="alarm",
                outcome=outcome,
                robot_id=source if self._is_robot(source) else None,
                ref=live.id,
                text=f"{live.type.title}. {text}".strip(),
                data={"priority": int(live.priority), "text": live.alarm.text},
            )
        )


def _person(session: SessionInfo) -> Person:
    return Person(session.user_name, session.device_name)
