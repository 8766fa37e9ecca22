"""What is put aside is told to nobody, and told when it is back and waits for an answer."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest

from hmi.app import notifications
from hmi.app.notifications import NotificationRoom
from hmi.app.records import Records
from hmi.clock import FakeClock
from hmi.domain.alarm.alarm import CONSOLE, AlarmKey
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.conditions import Change, Turn
from hmi.domain.alarm.finding import Finding
from hmi.domain.alarm.live_alarm import Step, What
from hmi.domain.alarm.priority import Priority
from hmi.notifications.channel import Channel, Webhook
from hmi.notifications.message import Message
from hmi.presenters import alarms as shown
from hmi.security.authorization import Authorizer
from hmi.settings import Settings
from hmi.store.alarms import AlarmStore, Person

MARTHA = Person("Martha Keller", "Tablet 3")
OFF_TRACK, LINK = AlarmKey("off-track", "w"), AlarmKey("link-lost", "w")
TOLD = frozenset({What.RAISED, What.RETURNED, What.ACKNOWLEDGED, What.ESCALATED})


class Telling:
    """Alarms, the events of the lane, and a channel that hears every occasion."""

    def __init__(self, records: Records, settings: Settings, clock: FakeClock) -> None:
        self.clock, self.store = clock, AlarmStore(clock, catalogue())
        self.room = NotificationRoom(settings, clock, records, Authorizer(records.robots.of_any_farm), self.store)
        ways = Channel("c", "Mail", True, Webhook("https://x/y"), frozenset(Priority), TOLD, per_hour=600)
        self.room.post.set_channels([ways])
        self.events: list[dict[str, Any]] = []
        self.sent: list[tuple[str, str]] = []
        self.store.listeners.append(self._step)

    def _step(self, step: Step) -> None:
        self.room.tell(step, "Weeder 1")
        self.events.append(shown.event(step, "Weeder 1"))

    async def deliver(self, _channel: Channel, message: Message, _rules: object) -> None:
        """Take a message."""
        self.sent += [(one.what.value, one.id.partition(".")[0]) for one in message.items]

    def turn(self, turn: Turn, key: AlarmKey = OFF_TRACK) -> None:
        """Let a condition come or go."""
        self.store.apply([Change(turn, key, Finding(key.code, "0.4 m to the left."))])

    def shelve(self) -> None:
        """Put it on the shelf for a quarter of an hour."""
        self.store.shelve(OFF_TRACK.id, MARTHA, "being mended", self.clock.utc() + timedelta(minutes=15))

    async def heard(self) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]:
        """Return what went out and what the lane said since this was asked last."""
        await self.room.post.send_due()
        sent, self.sent = self.sent, []
        events, self.events = self.events, []
        return sent, [(one["what"], one["state"]) for one in events]


@pytest.fixture
def telling(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Telling]:
    """Return alarms with one that was raised and acknowledged."""
    clock = FakeClock()
    given = {"data": tmp_path, "farm_id": "farm", "secret": "s" * 40, "port": 0}
    settings = Settings.model_validate(given)
    records = Records(settings, clock, lambda _robot_id: False)
    records.open()
    telling = Telling(records, settings, clock)
    monkeypatch.setattr(notifications, "deliver", telling.deliver)
    telling.turn(Turn.COMES)
    telling.store.acknowledge(OFF_TRACK.id, MARTHA)
    yield telling
    records.close()


async def test_what_comes_and_goes_on_the_shelf_is_told_when_it_is_back_and_still_so(telling: Telling) -> None:
    telling.shelve()
    await telling.heard()
    for turn in (Turn.GOES, Turn.COMES, Turn.GOES, Turn.COMES):
        telling.turn(turn)
    sent, said = await telling.heard()
    assert sent == []
    assert {state for _, state in said} == {"shelved"}, "whoever speaks it leaves it out by that"
    telling.clock.advance(15 * 60)
    telling.store.pass_time()
    assert await telling.heard() == ([("raised", "off-track")], [("unshelved", "unacknowledged")])


async def test_what_went_away_on_the_shelf_unseen_is_told_as_gone_when_it_is_back(telling: Telling) -> None:
    telling.shelve()
    for turn in (Turn.GOES, Turn.COMES, Turn.GOES):
        telling.turn(turn)
    await telling.heard()
    telling.store.unshelve(OFF_TRACK.id, MARTHA)
    assert await telling.heard() == ([("returned", "off-track")], [("unshelved", "returned")])


async def test_what_ended_on_the_shelf_is_told_to_nobody(telling: Telling) -> None:
    telling.shelve()
    telling.turn(Turn.GOES)
    await telling.heard()
    telling.store.unshelve(OFF_TRACK.id, MARTHA)
    sent, _said = await telling.heard()
    assert sent == []


async def test_what_is_back_in_service_or_after_its_cause_ended_is_told(telling: Telling) -> None:
    telling.store.take_out(OFF_TRACK.id, MARTHA, "being mended")
    telling.turn(Turn.COMES, LINK)
    await telling.heard()
    telling.store.put_back(OFF_TRACK.id, MARTHA)
    assert (await telling.heard())[0] == [("raised", "off-track")]
    telling.turn(Turn.COMES, AlarmKey("broker-lost", CONSOLE))
    await telling.heard()
    telling.turn(Turn.GOES, AlarmKey("broker-lost", CONSOLE))
    sent, _said = await telling.heard()
    assert ("raised", "link-lost") in sent


async def test_what_is_shown_is_told_when_it_goes_away_seen_or_not(telling: Telling) -> None:
    await telling.heard()
    telling.turn(Turn.GOES)
    assert (await telling.heard())[0] == [("returned", "off-track")]
