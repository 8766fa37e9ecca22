"""Who is notified of alarms and when nobody's answer escalates: changed and tested by admins, and written down."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from hmi.clock import Clock
from hmi.commands.ports import AuditSink
from hmi.commands.refusal import OrderRefused
from hmi.domain.alarm.priority import Priority
from hmi.domain.role import Permission
from hmi.notifications.address import AddressRules
from hmi.notifications.book import ChannelBook, plain
from hmi.notifications.channel import LEFT_OUT, Channel, Webhook
from hmi.notifications.errors import BadAddress, BadChannel
from hmi.notifications.post import PostOffice
from hmi.security.authorization import Authorize
from hmi.security.session_info import SessionInfo
from hmi.store.alarm_settings import AlarmSettings
from hmi.store.alarms import ESCALATION, AlarmStore, escalation_of
from hmi.store.audit_chain import AuditEntry
from hmi.store.database import Database
from hmi.store.errors import NotFound

MASK = "••••••••"
CHANGED = "changed"


@dataclass(frozen=True, slots=True)
class SettingsParts:
    """What the desk needs."""

    store: AlarmStore
    settings: AlarmSettings
    book: ChannelBook
    post: PostOffice
    rules: AddressRules
    database: Database
    audit: AuditSink
    authorize: Authorize
    clock: Clock
    farm_name: str


class AlarmSettingsDesk:
    """Every method raises ``NotSignedIn`` and ``NotAllowed`` for people without the right."""

    def __init__(self, parts: SettingsParts) -> None:
        self._parts = parts
        self._revision = 0
        self._lock = asyncio.Lock()

    async def load(self) -> None:
        """Read channels and limits into memory."""
        parts = self._parts
        stored = await parts.database.run(parts.settings.get, ESCALATION)
        parts.store.escalate_after_s = escalation_of(stored)
        parts.post.set_channels(await parts.database.run(parts.book.load))
        self._revision = await parts.database.run(parts.book.revision)

    def view(self, session: SessionInfo) -> dict[str, Any]:
        """Return everything that is set; a secret is shown as set or not, never itself."""
        self._parts.authorize(session, Permission.MANAGE_ALARMS)
        health = self._parts.post.health()
        return {
            "revision": self._revision,
            "channels": [self._shown(one, health) for one in self._parts.post.channels()],
            "escalate_after_s": {str(int(p)): self._parts.store.escalate_after_s.get(p) for p in Priority},
            "private_allowed": self._parts.rules.is_private_allowed,
            "hosts": list(self._parts.rules.hosts),
        }

    async def change(
        self,
        session: SessionInfo,
        channels: Sequence[Channel] | None,
        secrets: Mapping[str, str | None],
        escalate_after_s: Mapping[str, float | None] | None,
        revision: int | None = None,
    ) -> dict[str, Any]:
        """Replace channels and limits, ``None`` leaves them.

        A secret that is ``None`` stays, an empty one goes, an address as shown stays.
        A secret stays only while the address it is for stays: a new address never gets an old password.

        Args:
            revision: of the view that the person saw; ``None`` replaces whatever is there.

        Raises:
            OrderRefused: somebody changed it since that view; nothing was changed.
            BadChannel, BadAddress: what is set cannot be used; nothing was changed.
        """
        self._parts.authorize(session, Permission.MANAGE_ALARMS)
        async with self._lock:
            if revision not in (None, self._revision):
                raise OrderRefused(CHANGED, "Somebody changed it meanwhile.")
            await self._replace(session, channels, secrets, escalate_after_s)
        return self.view(session)

    async def _replace(
        self,
        session: SessionInfo,
        channels: Sequence[Channel] | None,
        secrets: Mapping[str, str | None],
        escalate_after_s: Mapping[str, float | None] | None,
    ) -> None:
        parts = self._parts
        before = {one.id: one for one in parts.post.channels()}
        whole = list(before.values()) if channels is None else self._whole(channels, before, secrets)
        limits = parts.store.escalate_after_s if escalate_after_s is None else escalation_of(escalate_after_s)
        stored = {str(int(p)): limits.get(p) for p in Priority}
        revision = self._revision + 1
        await parts.database.run(parts.book.save, whole, revision, {ESCALATION: stored}, session.user_name)
        self._revision = revision
        parts.store.escalate_after_s = limits
        parts.post.set_channels(whole)
        self._note(session, "changed", {"channels": [plain(one) for one in whole], "escalate_after_s": stored})

    def _whole(
        self, channels: Sequence[Channel], before: Mapping[str, Channel], secrets: Mapping[str, str | None]
    ) -> list[Channel]:
        if len({one.id for one in channels}) != len(channels):
            raise BadChannel("Two channels have the same id.", "channels")
        known = [_with_address(one, before.get(one.id)) for one in channels]
        whole = [self._with_secret(one, before.get(one.id), secrets.get(one.id)) for one in known]
        for one in whole:
            one.check()
            self._check_address(one)
        return whole

    async def test(self, session: SessionInfo, channel_id: str) -> tuple[bool, str]:
        """Send a test by one channel; return whether it went out, and a sentence."""
        self._parts.authorize(session, Permission.MANAGE_ALARMS)
        channel = next((one for one in self._parts.post.channels() if one.id == channel_id), None)
        if channel is None:
            raise NotFound(f"there is no channel {channel_id!r}")
        problem = await self._parts.post.test(channel, self._parts.farm_name)
        self._note(session, "tested", {"channel": channel_id, "problem": problem})
        return not problem, problem or "The other side took it."

    def _with_secret(self, new: Channel, old: Channel | None, secret: str | None) -> Channel:
        if secret is not None and secret != MASK:
            return replace(new, secret=secret)
        is_same = old is not None and _goes_to(old) == _goes_to(new)
        return replace(new, secret=old.secret if old is not None and is_same else "")

    def _check_address(self, channel: Channel) -> None:
        try:
            if isinstance(channel.way, Webhook):
                self._parts.rules.check_url(channel.way.url)
            else:
                self._parts.rules.check_host(channel.way.host)
        except BadAddress as error:
            raise BadChannel(error.text, "url" if isinstance(channel.way, Webhook) else "host") from error

    def _shown(self, channel: Channel, health: Mapping[str, Any]) -> dict[str, Any]:
        found = health[channel.id]
        sent_at = found.last_sent_at
        return {
            **plain(channel),
            "secret": MASK if channel.secret else "",
            "health": {
                "waiting": found.waiting,
                "sent": found.sent,
                "failed": found.failed,
                "dropped": found.dropped,
                "last_error": found.last_error,
                "last_sent": None if sent_at is None else round(sent_at.timestamp() * 1000),
            },
        }

    def _note(self, session: SessionInfo, outcome: str, data: dict[str, Any]) -> None:
        entry = AuditEntry(
            session.farm_id, session.user_name, session.device_name, "alarm_settings", outcome, data=data
        )
        self._parts.audit.append(entry)


def _with_address(new: Channel, old: Channel | None) -> Channel:
    if not isinstance(new.way, Webhook) or LEFT_OUT not in new.way.url:
        return new
    if old is not None and isinstance(old.way, Webhook) and old.way.shown == new.way.url:
        return replace(new, way=old.way)
    raise BadChannel("Type the whole address: the part that is not shown is not known for this one.", "url")


def _goes_to(channel: Channel) -> tuple[object, ...]:
    way = channel.way
    return ("webhook", way.url) if isinstance(way, Webhook) else ("email", way.host, way.port, way.user, way.security)
