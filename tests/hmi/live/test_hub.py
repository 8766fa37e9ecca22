"""One encoding for all, deltas only of what changed, and a slow browser never costs memory or truth."""

from __future__ import annotations

import struct
from typing import Any

import pytest

from hmi.live import inside, topics
from hmi.live.hub import FLEET_S
from hmi.live.outbox import DELTA_LIMIT, EVENT_AGE_S, EVENT_CHARS, EVENT_LIMIT
from hmi.presenters.operate import PRESENTERS
from tests.hmi.live.rig import HubRig

ID = "weeder-01"
TOPIC = f"robot/{ID}"


def test_a_subscription_is_answered_with_the_whole_state() -> None:
    rig = HubRig(ID)
    rig.move(ID)
    frame = rig.take(rig.lane(TOPIC))[0]
    assert frame["k"] == "snap"
    assert set(frame["d"][TOPIC]) == {*PRESENTERS, "lease"}
    assert frame["d"][TOPIC]["pose"]["speed_mps"] == 0.42
    assert frame["d"][TOPIC]["mission"] is None


def test_a_delta_carries_only_the_groups_that_changed() -> None:
    rig = HubRig(ID)
    rig.move(ID)
    lane = rig.lane(TOPIC)
    first = rig.take(lane)[0]
    rig.hub.flush()
    rig.clock.advance(0.1)
    rig.move(ID, 0.30)
    rig.hub.flush()
    delta = rig.take(lane)[-1]
    assert delta["k"] == "delta"
    assert set(delta["d"][TOPIC]) == {"pose", "tiles"}
    assert delta["rev"] > first["rev"]


def test_nothing_is_sent_when_nothing_changed() -> None:
    rig = HubRig(ID)
    rig.move(ID)
    lane = rig.lane(TOPIC)
    rig.take(lane)
    rig.hub.flush()
    rig.take(lane)
    rig.hub.flush()
    assert rig.take(lane) == []


def test_every_lane_is_handed_the_same_object() -> None:
    rig = HubRig(ID)
    lanes = [rig.lane(TOPIC) for _ in range(3)]
    for lane in lanes:
        rig.take(lane)
    rig.move(ID)
    rig.hub.flush()
    frames = [lane.take(rig.hub.snapshot)[-1] for lane in lanes]
    assert frames[0] is frames[1] is frames[2]


def test_a_lane_hears_only_what_it_asked_for() -> None:
    rig = HubRig(ID, "weeder-02")
    lane = rig.lane("robot/weeder-02")
    rig.take(lane)
    rig.hub.flush()
    rig.take(lane)
    rig.move(ID)
    rig.hub.flush()
    assert rig.take(lane) == []


def test_a_new_subscription_replaces_the_old_one() -> None:
    rig = HubRig(ID, "weeder-02")
    lane = rig.lane(TOPIC)
    rig.take(lane)
    rig.hub.subscribe(lane, ["robot/weeder-02"])
    assert list(rig.take(lane)[0]["d"]) == ["robot/weeder-02"]
    rig.move(ID)
    rig.hub.flush()
    assert all(TOPIC not in frame["d"] for frame in rig.take(lane))


@pytest.mark.parametrize("topic", ["robot/", "robot/../x", 'robot/a"b', "ROBOT/a", "secrets", ""])
def test_what_is_no_topic_is_ignored(topic: str) -> None:
    rig = HubRig(ID)
    lane = rig.lane(topic)
    assert rig.take(lane)[0]["d"] == {}


def test_a_robot_that_appears_later_fills_a_topic_that_waits_for_it() -> None:
    rig = HubRig()
    lane = rig.lane(TOPIC)
    assert rig.take(lane)[0]["d"][TOPIC]["id"] is None
    rig.move(ID)
    rig.hub.flush()
    merged: dict[str, Any] = {}
    for frame in rig.take(lane):
        merged |= frame["d"][TOPIC]
    assert merged["id"]["is_registered"] is False
    assert merged["pose"]["speed_mps"] == 0.42


def test_a_robot_taken_out_of_the_registry_empties_its_topic() -> None:
    rig = HubRig(ID)
    rig.move(ID)
    lane = rig.lane(TOPIC)
    rig.take(lane)
    rig.store.set_registry([])
    rig.hub.flush()
    assert rig.take(lane)[0]["d"][TOPIC]["id"] is None


def test_a_browser_that_does_not_keep_up_skips_to_a_fresh_snapshot() -> None:
    rig = HubRig(ID)
    slow, quick = rig.lane(TOPIC), rig.lane(TOPIC)
    rig.take(slow)
    for step in range(DELTA_LIMIT + 10):
        rig.clock.advance(0.1)
        rig.move(ID, step / 100)
        rig.hub.flush()
        rig.take(quick)
    frames = rig.take(slow)
    assert [f["k"] for f in frames] == ["snap"]
    assert frames[0]["d"][TOPIC]["pose"]["speed_mps"] == pytest.approx((DELTA_LIMIT + 9) / 100)
    rig.clock.advance(0.1)
    rig.move(ID, 0.99)
    rig.hub.flush()
    assert [f["k"] for f in rig.take(slow)] == ["delta"]


def test_a_browser_far_behind_gets_ticks_until_it_has_caught_up() -> None:
    rig = HubRig(ID)
    lane = rig.lane(TOPIC)
    rig.take(lane)
    lane.seen(rig.clock.mono_s() * 1000 - 5000)  # megabytes lie in buffers between us
    rig.move(ID, 0.1)
    rig.hub.flush()
    rig.hub.beat()
    assert [f["k"] for f in rig.take(lane)] == ["tick"]
    lane.seen(rig.clock.mono_s() * 1000 - 100)
    frames = rig.take(lane)
    assert [f["k"] for f in frames] == ["snap"]
    assert frames[0]["d"][TOPIC]["pose"]["speed_mps"] == 0.1


def test_events_are_never_conflated() -> None:
    rig = HubRig(ID)
    lane = rig.lane()
    for number in range(100):
        rig.hub.event({"kind": "command", "n": number})
    assert [f["d"]["n"] for f in rig.take(lane)] == list(range(100))


def test_what_a_thousand_robots_tell_in_one_moment_ends_no_lane() -> None:
    rig = HubRig(ID)
    lane = rig.lane()
    for number in range(3000):
        rig.hub.event({"kind": "lease", "n": number, "text": "x" * 400})
    assert not lane.is_overrun
    assert [f["d"]["n"] for f in rig.take(lane)] == list(range(3000))


def test_events_that_nobody_takes_for_long_end_the_lane() -> None:
    rig = HubRig(ID)
    lane = rig.lane()
    for number in range(EVENT_LIMIT):
        rig.hub.event({"n": number})
    rig.clock.advance(EVENT_AGE_S + 0.1)
    assert not lane.is_overrun
    rig.hub.event({"n": EVENT_LIMIT})
    assert lane.is_overrun
    assert len(rig.take(lane)) == EVENT_LIMIT


def test_a_lane_that_takes_its_events_lives_however_many_come() -> None:
    rig = HubRig(ID)
    lane = rig.lane()
    for number in range(10 * EVENT_LIMIT):
        rig.hub.event({"n": number})
        if number % EVENT_LIMIT == 0:
            rig.clock.advance(EVENT_AGE_S)
            rig.take_all(lane)
    assert not lane.is_overrun


def test_events_never_fill_the_memory() -> None:
    rig = HubRig(ID)
    lane = rig.lane()
    for _ in range(100):
        rig.hub.event({"text": "x" * 60_000})
    assert lane.is_overrun
    assert sum(len(frame) for frame in lane.take(rig.hub.snapshot)) <= EVENT_CHARS


def test_an_event_can_be_for_one_session_only() -> None:
    rig = HubRig(ID)
    martha, jonas = rig.lane(), rig.lane(name="jonas")
    rig.hub.event({"kind": "x"}, session_id="session-jonas")
    assert rig.take(martha) == []
    assert len(rig.take(jonas)) == 1


def test_only_the_newest_tick_waits() -> None:
    rig = HubRig(ID)
    lane = rig.lane()
    rig.hub.stop_state = "up"
    for _ in range(5):
        rig.clock.advance(0.1)
        rig.hub.beat()
    frames = rig.take(lane)
    assert [f["id"] for f in frames] == ["boot1-5"]
    assert frames[0]["m"] == pytest.approx(rig.clock.mono_s() * 1000)
    assert frames[0]["stop"] == "up"


def test_the_end_of_a_session_says_bye_to_all_its_lanes_and_to_no_other() -> None:
    rig = HubRig(ID)
    one, two, other = rig.lane(), rig.lane(), rig.lane(name="jonas")
    rig.hub.end_session("session-martha", "signed_out", "You signed out.")
    assert rig.take(one)[-1] == {"k": "bye", "code": "signed_out", "text": "You signed out."}
    assert two.is_ended
    assert not other.is_ended


def test_a_lease_reaches_who_listens_and_who_comes_later() -> None:
    rig = HubRig(ID)
    lane = rig.lane(TOPIC)
    rig.take(lane)
    lease = {"owner": {"user": "martha", "name": "Martha Keller"}, "since_s": 0, "asked": []}
    rig.hub.set_group(ID, "lease", lease)
    assert rig.take(lane)[0]["d"] == {TOPIC: {"lease": lease}}
    assert rig.take(rig.lane(TOPIC))[0]["d"][TOPIC]["lease"] == lease


def test_the_fleet_goes_out_at_most_twice_a_second_and_only_what_changed() -> None:
    rig = HubRig(ID, "weeder-02")
    rig.move(ID)
    rig.move("weeder-02")
    lane = rig.lane("fleet")
    assert set(rig.take(lane)[0]["d"]["fleet"]["robots"]) == {ID, "weeder-02"}
    rig.hub.beat()
    rig.take(lane)
    rig.pause(ID)
    rig.clock.advance(FLEET_S / 2)
    rig.hub.beat()
    assert [f["k"] for f in rig.take(lane)] == ["tick"]
    rig.clock.advance(FLEET_S / 2)
    rig.hub.beat()
    delta = rig.take(lane)[0]["d"]["fleet"]["robots"]
    assert list(delta) == [ID]
    assert delta[ID]["mode"] == "paused"
    assert not {"n", "name", "family", "field"} & delta[ID].keys(), "what stayed is not sent again"


def test_a_robot_that_only_moves_changes_no_entry_of_the_fleet() -> None:
    rig = HubRig(ID)
    rig.move(ID)
    lane = rig.lane("fleet")
    rig.hub.beat()
    rig.take(lane)
    for step in range(20):
        rig.clock.advance(FLEET_S)
        rig.move(ID, lat_deg=52.0 + step / 1000)
        rig.hub.beat()
        assert [f["k"] for f in rig.take(lane)] == ["tick"]


def test_when_robots_were_heard_goes_out_as_one_binary_frame() -> None:
    rig = HubRig(ID, "weeder-02")
    lane = rig.lane("fleet")
    rig.hub.beat()
    snapshot = rig.take(lane)[0]["d"]["fleet"]
    number = {i: e["n"] for i, e in snapshot["robots"].items()}
    assert sorted(number.values()) == [0, 1]
    assert snapshot["beats"] == {ID: [None, None], "weeder-02": [None, None]}
    rig.heartbeat("weeder-02", rtt_s=0.091)
    rig.clock.advance(FLEET_S)
    rig.hub.beat()
    rig.take_all(lane)  # it came online: that changes its entry, too
    rig.heartbeat("weeder-02", rtt_s=0.091)
    rig.clock.advance(FLEET_S)
    rig.hub.beat()
    (frame,) = [f for f in lane.take(rig.hub.snapshot) if isinstance(f, bytes)]
    magic, _rev, m, count = struct.unpack_from("<4sIdI", frame)
    assert (magic, m, count) == (b"HLB1", pytest.approx(rig.clock.mono_s() * 1000), 1)
    assert struct.unpack_from("<IHH", frame, 20) == (number["weeder-02"], 50, 91)


def test_a_robot_that_goes_silent_changes_its_entry_although_nothing_of_it_arrives() -> None:
    rig = HubRig(ID)
    rig.heartbeat(ID)
    lane = rig.lane("fleet")
    rig.hub.beat()
    rig.take(lane)
    rig.clock.advance(10)
    rig.store.refresh_links()
    rig.hub.beat()
    entry = rig.take(lane)[0]["d"]["fleet"]["robots"][ID]
    assert (entry["is_online"], entry["level"]) == (False, 2)


def test_a_robot_that_left_is_null_in_the_fleet() -> None:
    rig = HubRig(ID)
    lane = rig.lane("fleet")
    rig.take(lane)
    rig.hub.beat()
    rig.take(lane)
    rig.store.set_registry([])
    rig.clock.advance(1)
    rig.hub.beat()
    assert rig.take(lane)[0]["d"] == {"fleet": {"robots": {ID: None}}}


def test_places_go_out_as_one_binary_frame_of_what_moved() -> None:
    rig = HubRig(ID, "weeder-02")
    rig.move(ID)
    rig.move("weeder-02")
    lane = rig.lane("poses")
    assert rig.take(lane)[0]["d"]["poses"]["numbers"] == {ID: 0, "weeder-02": 1}
    rig.hub.beat()
    lane.take(rig.hub.snapshot)
    rig.clock.advance(0.1)
    rig.move("weeder-02", lat_deg=-33.5)
    rig.clock.advance(0.25)
    rig.hub.beat()
    frame = lane.take(rig.hub.snapshot)[0]
    assert isinstance(frame, bytes)
    magic, _rev, m, count = struct.unpack_from("<4sIdI", frame)
    assert (magic, m, count) == (b"HLP1", pytest.approx(rig.clock.mono_s() * 1000), 1)
    assert struct.unpack_from("<IiiHH", frame, 20) == (1, -335_000_000, 50_000_000, 9000, 25)


def test_the_places_of_silent_robots_are_in_the_snapshot_with_their_age() -> None:
    rig = HubRig(ID)
    rig.move(ID)
    rig.clock.advance(600)
    places = rig.take(rig.lane("poses"))[0]["d"]["poses"]["places"]
    assert places[ID][0] == 52.0
    assert rig.clock.mono_s() * 1000 - places[ID][3] == pytest.approx(600_000)


def test_places_of_a_crowd_go_out_at_the_rate_of_the_lists() -> None:
    ids = [f"weeder-{n:03}" for n in range(101)]
    rig = HubRig(*ids)
    lane = rig.lane("poses")
    rig.take_all(lane)
    frames = 0
    for _ in range(20):
        rig.move(ids[0])
        rig.clock.advance(0.1)
        rig.hub.beat()
        frames += sum(isinstance(f, bytes) for f in lane.take(rig.hub.snapshot))
    assert 3 <= frames <= 4


def test_a_lane_that_left_is_forgotten() -> None:
    rig = HubRig(ID)
    lane = rig.lane(TOPIC, "fleet", "poses")
    rig.hub.detach(lane)
    rig.hub.detach(lane)
    rig.move(ID)
    rig.hub.beat()
    rig.hub.beat()
    assert rig.hub.lanes == 0


def test_a_robot_that_cannot_be_shown_stops_neither_ticks_nor_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    rig = HubRig("bad", ID)
    lane = rig.lane("robot/bad", TOPIC, "inside/bad", "fleet", "alarms")
    rig.take(lane)

    def fails(robot: Any, *_more: Any) -> Any:
        if robot.id == "bad":
            raise OverflowError("cannot convert float infinity to integer")
        return {"state": "new"}

    monkeypatch.setitem(PRESENTERS, "pose", fails)
    monkeypatch.setitem(inside.MAKE, "nodes", fails)
    monkeypatch.setattr(topics.fleet, "slow", fails)
    for robot_id in ("bad", ID):
        rig.move(robot_id)
        rig.pause(robot_id)
    rig.clock.advance(FLEET_S)
    rig.hub.flush()
    rig.hub.beat()
    told = rig.take(lane)
    assert [frame["k"] for frame in told][-1] == "tick"
    assert any("pose" in frame["d"].get(TOPIC, {}) for frame in told if frame["k"] == "delta")
    late = rig.take(rig.lane("robot/bad", "inside/bad", "fleet", "alarms"))
    assert late[0]["k"] == "snap"
    assert late[0]["d"]["robot/bad"]["lease"] is None


def test_a_robot_that_cannot_be_listed_keeps_no_news_of_others_back_and_gets_old(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rig = HubRig(ID, "bad", "weeder-02")
    lane = rig.lane("fleet")
    for robot_id in (ID, "bad", "weeder-02"):
        rig.heartbeat(robot_id)
    rig.clock.advance(FLEET_S)
    rig.hub.beat()
    rig.take(lane)
    slow = topics.fleet.slow

    def fails(robot: Any, *more: Any) -> dict[str, Any]:
        if robot.id == "bad":
            raise OverflowError("cannot convert float infinity to integer")
        return slow(robot, *more)

    monkeypatch.setattr(topics.fleet, "slow", fails)
    for robot_id in (ID, "bad", "weeder-02"):
        rig.pause(robot_id)
        rig.heartbeat(robot_id)
    rig.clock.advance(FLEET_S)
    rig.hub.beat()
    (told,) = [frame["d"]["fleet"]["robots"] for frame in rig.take(lane) if frame["k"] == "delta"]
    assert {robot_id: entry["mode"] for robot_id, entry in told.items()} == {ID: "paused", "weeder-02": "paused"}
    whole = rig.take(rig.lane("fleet", name="anna"))[0]["d"]["fleet"]
    assert whole["robots"].keys() == {ID, "bad", "weeder-02"}
    assert whole["beats"].keys() == {ID, "weeder-02"}
    monkeypatch.setattr(topics.fleet, "slow", slow)
    rig.pause("bad")
    rig.heartbeat("bad")
    rig.clock.advance(FLEET_S)
    rig.hub.beat()
    (told,) = [frame["d"]["fleet"]["robots"] for frame in rig.take(lane) if frame["k"] == "delta"]
    assert told["bad"]["mode"] == "paused"
