"""Lane topic ``alarms``: whole at first, then only what changed, and never older than the supervision says."""

from __future__ import annotations

from typing import Any

from hmi.clock import FakeClock
from hmi.domain.alarm.alarm import AlarmKey
from hmi.domain.alarm.catalogue import catalogue
from hmi.domain.alarm.conditions import Change, Turn
from hmi.domain.alarm.finding import Finding
from hmi.domain.freshness import TickRing
from hmi.live.hub import LiveHub
from hmi.presenters import alarms as shown
from hmi.store.alarms import AlarmStore, Person
from tests.hmi.live.rig import HubRig

LINK = "link-lost.weeder-01"


class _Source:
    """The store as the hub asks it."""

    def __init__(self, store: AlarmStore) -> None:
        self.store = store

    @property
    def revision(self) -> int:
        return self.store.revision

    def entries_since(self, revision: int) -> dict[str, dict[str, Any] | None]:
        found = self.store.since(revision)
        return {i: None if one is None else shown.entry(one, "Weeder 01") for i, one in found.items()}

    def summary(self) -> dict[str, Any]:
        return shown.summary(self.store.counts(), None, self.store.checked_s)


class AlarmHub(HubRig):
    """A hub with alarms."""

    def __init__(self) -> None:
        super().__init__("weeder-01")
        self.clock = FakeClock()
        self.alarms = AlarmStore(self.clock, catalogue())
        ticks = TickRing("boot1", self.clock.mono_s, self.clock.utc)
        self.hub = LiveHub(self.store, ticks, self.clock, alarms=_Source(self.alarms))

    def turn(self, turn: Turn, code: str = "link-lost") -> None:
        """Let a condition come or go."""
        self.alarms.apply([Change(turn, AlarmKey(code, "weeder-01"), Finding(code, "so"))])

    def beats(self, number: int) -> None:
        """Let tenths of a second pass."""
        for _ in range(number):
            self.clock.advance(0.1)
            self.hub.beat()


def test_a_new_lane_gets_every_alarm_and_the_summary() -> None:
    rig = AlarmHub()
    rig.turn(Turn.COMES)
    topic = rig.take(rig.lane("alarms"))[0]["d"]["alarms"]
    assert topic["alarms"][LINK]["state"] == "unacknowledged"
    assert topic["summary"]["counts"]["2"] == [1, 1]


def test_changes_come_at_most_twice_a_second_and_a_normal_one_as_null() -> None:
    rig = AlarmHub()
    rig.turn(Turn.COMES)
    lane = rig.lane("alarms")
    rig.take(lane)
    rig.turn(Turn.COMES, "battery-low")
    rig.alarms.acknowledge(LINK, Person("Martha"))
    rig.turn(Turn.GOES)
    rig.beats(10)
    deltas = [one["d"]["alarms"] for one in rig.take(lane) if one["k"] == "delta"]
    assert 1 <= len(deltas) <= 2
    assert deltas[0]["alarms"][LINK] is None
    assert set(deltas[0]["alarms"]) == {LINK, "battery-low.weeder-01"}


def test_nothing_is_sent_while_nothing_changes_but_the_last_round_is_told() -> None:
    rig = AlarmHub()
    rig.turn(Turn.COMES)
    lane = rig.lane("alarms")
    rig.take(lane)
    rig.beats(10)
    assert [one for one in rig.take(lane) if one["k"] == "delta"] == []
    rig.alarms.pass_time()
    rig.beats(10)
    deltas = [one["d"]["alarms"] for one in rig.take(lane) if one["k"] == "delta"]
    assert [one["alarms"] for one in deltas] == [{}]
    assert deltas[0]["summary"]["checked"] > 1_000_000


def test_who_listens_again_after_a_pause_sees_nothing_that_ended_meanwhile() -> None:
    rig = AlarmHub()
    rig.turn(Turn.COMES)
    lane = rig.lane("alarms")
    rig.hub.subscribe(lane, [])
    rig.alarms.acknowledge(LINK, Person("Martha"))
    rig.turn(Turn.GOES)
    rig.hub.subscribe(lane, ["alarms"])
    assert rig.take(lane)[-1]["d"]["alarms"]["alarms"] == {}
