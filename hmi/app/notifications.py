"""Notifications in the console: channels, post office and settings, plugged together."""

from __future__ import annotations

from collections.abc import Callable

from fastapi import APIRouter

from hmi.api.alarm_settings import alarm_settings_routes
from hmi.app.records import Records
from hmi.clock import Clock
from hmi.commands.alarm_settings_desk import AlarmSettingsDesk, SettingsParts
from hmi.domain.alarm.finding import MAX_TEXT, Finding, Findings, detail_of
from hmi.domain.alarm.live_alarm import Step, What
from hmi.notifications.address import AddressRules
from hmi.notifications.book import ChannelBook
from hmi.notifications.channel import Channel
from hmi.notifications.message import Message, Told
from hmi.notifications.post import PostOffice
from hmi.notifications.secret_box import SecretBox
from hmi.notifications.ways import deliver
from hmi.presenters.alarms import title_of, words
from hmi.security.authorization import Authorize
from hmi.settings import Settings
from hmi.store.alarm_settings import AlarmSettings
from hmi.store.alarms import AlarmStore

FAILING_S = 300.0
_BACK = (What.UNSHELVED, What.UNSUPPRESSED, What.IN_SERVICE)


class NotificationRoom:
    """Tells people outside the screen."""

    def __init__(
        self, settings: Settings, clock: Clock, records: Records, authorize: Authorize, store: AlarmStore
    ) -> None:
        self._farm, self._clock = settings.farm_name, clock
        self._rules = AddressRules(tuple(one.lower() for one in settings.notify_hosts), settings.notify_private)
        self.post = PostOffice(clock, self._deliver)
        self.responsible_for: Callable[[str], str] = lambda _source: ""
        kept = AlarmSettings(records.database, settings.farm_id)
        self.desk = AlarmSettingsDesk(
            SettingsParts(
                store=store,
                settings=kept,
                book=ChannelBook(kept, SecretBox(settings.data / "keys" / "notifications.key"), clock),
                post=self.post,
                rules=self._rules,
                database=records.database,
                audit=records.audit,
                authorize=authorize,
                clock=clock,
                farm_name=settings.farm_name,
            )
        )

    def routes(self) -> APIRouter:
        """Return the REST routes."""
        return alarm_settings_routes(self.desk)

    def tell(self, step: Step, name: str) -> None:
        """Take a step in the life of an alarm; never waits. What is not shown to people is not told either."""
        live, what = step.live, _occasion(step)
        if what is None:
            return
        self.post.tell(
            self._farm,
            Told(
                id=live.id,
                what=what,
                at=step.at,
                priority=live.priority,
                source=live.alarm.key.source,
                name=name,
                title=title_of(live),
                text=live.alarm.text,
                steps=tuple(words(live.type, live.alarm.advice)["steps"]),
                by=step.by,
                responsible=self.responsible_for(live.alarm.key.source),
            ),
        )

    def findings(self) -> Findings:
        """Return the channels by which nothing gets out for a while."""
        now_s = self._clock.mono_s()
        names = {one.id: one.name for one in self.post.channels()}
        return tuple(
            Finding("notification-failed", f"{names[i]}: {one.last_error}"[:MAX_TEXT], detail_of(i))
            for i, one in self.post.health().items()
            if one.failing_since_s is not None and now_s - one.failing_since_s >= FAILING_S
        )

    async def _deliver(self, channel: Channel, message: Message) -> None:
        await deliver(channel, message, self._rules)


def _occasion(step: Step) -> What | None:
    """Return what a step is told as, ``None`` if it is not: what came and went aside is told when it is back."""
    alarm = step.live.alarm
    if alarm.is_aside:
        return None
    if step.what not in _BACK:
        return step.what
    if not alarm.awaits_answer:
        return None
    return What.RAISED if alarm.is_active else What.RETURNED
