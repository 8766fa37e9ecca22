"""The settings of notifications: read, and kept with their secrets sealed. Blocking."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from hmi.clock import Clock
from hmi.domain.alarm.live_alarm import What
from hmi.domain.alarm.priority import Priority
from hmi.notifications.channel import Channel, Kind, Mail, Security, Webhook
from hmi.notifications.secret_box import SecretBox
from hmi.store.alarm_settings import AlarmSettings

NAME = "notifications"


class ChannelBook:
    """The channels of one farm."""

    def __init__(self, settings: AlarmSettings, box: SecretBox, clock: Clock) -> None:
        self._settings, self._box, self._clock = settings, box, clock

    def load(self) -> list[Channel]:
        """Return the channels; blocks."""
        stored = self._settings.get(NAME) or {}
        return [self._read(one) for one in stored.get("channels", [])]

    def revision(self) -> int:
        """Return how often they were saved; blocks."""
        return int((self._settings.get(NAME) or {}).get("revision", 0))

    def save(
        self, channels: Sequence[Channel], revision: int, beside: Mapping[str, Mapping[str, Any]], by: str
    ) -> None:
        """Keep the channels and the settings ``beside`` them, by name: all or none; blocks."""
        kept = {"channels": [self._written(one) for one in channels], "revision": revision}
        self._settings.put_all({NAME: kept, **beside}, by, self._clock.utc())

    def _written(self, channel: Channel) -> dict[str, Any]:
        sealed = {"secret": self._box.seal(channel.secret)}
        if isinstance(channel.way, Webhook):
            sealed["address"] = self._box.seal(channel.way.url)
        return {**plain(channel), **sealed}

    def _read(self, stored: Mapping[str, Any]) -> Channel:
        if "address" in stored:  # one that was kept before addresses were sealed has it as its url
            stored = {**stored, "url": self._box.open(str(stored["address"]))}
        channel = channel_of(stored)
        return replace(channel, secret=self._box.open(str(stored.get("secret", ""))))


def plain(channel: Channel) -> dict[str, Any]:
    """Return a channel as JSON carries it, without its secret and without what an address keeps secret."""
    way = channel.way
    shared: dict[str, Any] = {
        "id": channel.id,
        "name": channel.name,
        "kind": channel.kind.value,
        "is_on": channel.is_on,
        "priorities": sorted(int(one) for one in channel.priorities),
        "steps": sorted(one.value for one in channel.steps),
        "robots": sorted(channel.robots),
        "per_hour": channel.per_hour,
    }
    if isinstance(way, Webhook):
        return {**shared, "url": way.shown}
    return {
        **shared,
        "host": way.host,
        "port": way.port,
        "security": way.security.value,
        "user": way.user,
        "sender": way.sender,
        "recipients": list(way.recipients),
    }


def channel_of(given: Mapping[str, Any], secret: str = "") -> Channel:
    """Return a channel from its JSON."""
    way: Webhook | Mail
    if given["kind"] == Kind.WEBHOOK.value:
        way = Webhook(given["url"])
    else:
        way = Mail(
            given["host"],
            given["port"],
            Security(given["security"]),
            given["user"],
            given["sender"],
            tuple(given["recipients"]),
        )
    return Channel(
        id=given["id"],
        name=given["name"],
        is_on=given["is_on"],
        way=way,
        priorities=frozenset(Priority(one) for one in given["priorities"]),
        steps=frozenset(What(one) for one in given["steps"]),
        robots=frozenset(given["robots"]),
        per_hour=given["per_hour"],
        secret=secret,
    )
