"""Topic ``inside``: made only while watched, ten times a second at most, judged again where silence matters."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hmi.domain import machine
from hmi.domain import robot as domain
from hmi.domain.state_chart import ActiveState, LastTransition
from hmi.live import frames
from tests.hmi.live.rig import HubRig
from tests.hmi.presenters.robots import SHEET

TOPIC = "inside/planter-02"


def enter(rig: HubRig, *ids: str) -> None:
    """Let the robot report which states are active."""
    now_s = rig.clock.mono_s()
    rig.store.admit("planter-02")
    active = tuple(ActiveState(i, now_s - 3) for i in ids)
    last = LastTransition("idle", ids[-1], "started", "ok", now_s - 3)
    stamp = domain.Stamp(now_s, now_s)
    state = domain.RobotState(domain.Mode.AUTO, ids, now_s, 0, None, None, (), None, stamp, active, last)
    rig.store.put_state("planter-02", state)
    rig.store.announce()


def move(rig: HubRig, slew: float) -> None:
    """Let joints and gauges arrive."""
    now_s = rig.clock.mono_s()
    rig.store.admit("planter-02")
    body = machine.Body({"slew": slew}, {"slew": 0.5}, {"tilt": 9.0}, None, True, 61, (), domain.Stamp(now_s, now_s))
    rig.store.put_body("planter-02", body)
    rig.store.announce()


def deltas(rig: HubRig, lane: object) -> list[dict[str, object]]:
    """Return what was sent about the topic."""
    return [f["d"][TOPIC] for f in rig.take(lane) if f["k"] == "delta" and TOPIC in f["d"]]  # type: ignore[arg-type]


def test_a_watcher_sees_which_states_are_active_since_when_and_the_last_change() -> None:
    rig = HubRig("planter-02")
    enter(rig, "mission", "transit")
    lane = rig.lane(TOPIC)
    (snapshot,) = [f for f in rig.take(lane) if f["k"] == "snap"]
    active = snapshot["d"][TOPIC]["active"]
    since = (rig.clock.mono_s() - 3) * 1000
    assert active["states"] == [["mission", since], ["transit", since]]
    assert active["last"] == {"source": "idle", "target": "transit", "event": "started", "result": "ok", "at": since}


def test_changes_go_out_with_the_tick_so_ten_times_a_second_at_most() -> None:
    rig = HubRig("planter-02")
    lane = rig.lane(TOPIC)
    rig.take(lane)
    for ids in (("idle",), ("mission",), ("mission", "transit")):
        enter(rig, *ids)
        rig.hub.flush()
    assert deltas(rig, lane) == []
    rig.hub.beat()
    (sent,) = deltas(rig, lane)
    assert [one[0] for one in sent["active"]["states"]] == ["mission", "transit"]  # type: ignore[index]
    rig.hub.beat()
    assert deltas(rig, lane) == []


def test_a_joint_beyond_its_soft_limit_and_a_gauge_outside_its_range_warn() -> None:
    rig = HubRig("planter-02")
    sheet = replace(
        SHEET,
        joints=(machine.JointInfo("slew", "Slew", "rad", -3.0, 3.0, 0.5, -2.5, 2.5),),
        gauges=(machine.GaugeInfo("tilt", "Tilt", "deg", 0, 20, 0, 8, "8 degrees"),),
    )
    rig.store.admit("planter-02")
    rig.store.put_factsheet("planter-02", sheet)
    move(rig, 2.6)
    lane = rig.lane(TOPIC)
    (snapshot,) = [f for f in rig.take(lane) if f["k"] == "snap"]
    inside = snapshot["d"][TOPIC]
    assert (inside["joints"]["joints"][0]["value"], inside["joints"]["joints"][0]["level"]) == (2.6, 2)
    assert inside["gauges"]["gauges"][0]["level"] == 2
    rig.clock.advance(0.1)
    move(rig, 1.0)
    rig.hub.flush()
    rig.hub.beat()
    (sent,) = deltas(rig, lane)
    assert set(sent) == {"joints", "gauges", "seen"}
    assert sent["joints"]["joints"][0]["level"] is None  # type: ignore[index]


def test_nothing_is_made_for_a_robot_that_nobody_watches(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    monkeypatch.setattr("hmi.live.inside.state_chart.active", lambda robot: made.append(robot.id))
    rig = HubRig("planter-02", "weeder-01")
    lane = rig.lane("inside/weeder-01")
    enter(rig, "idle")
    rig.hub.flush()
    rig.hub.beat()
    assert set(made) == {"weeder-01"}
    rig.hub.subscribe(lane, [TOPIC])
    assert made.count("planter-02") == 1
    rig.hub.subscribe(lane, [])
    enter(rig, "mission")
    rig.hub.flush()
    rig.hub.beat()
    assert made.count("planter-02") == 1


def test_a_topic_needs_an_id_of_a_robot() -> None:
    assert frames.is_topic(TOPIC)
    assert not frames.is_topic("inside/")
    assert not frames.is_topic("inside/Planter 02")
    assert not frames.is_topic("outside/planter-02")


def test_what_cameras_found_goes_out_with_the_time_of_its_picture_the_newest_camera_first() -> None:
    rig = HubRig("planter-02")
    lane = rig.lane(TOPIC)
    rig.take(lane)
    now_s = rig.clock.mono_s()
    rig.store.admit("planter-02")
    box = machine.SeenBox("obstacle", 0.1, 0.2, 0.3, 0.4, 0.9, None)
    for camera, age_s in (("rear", 0.3), ("head", 0.1)):
        stamp = domain.Stamp(now_s - age_s, now_s)
        rig.store.put_sight("planter-02", machine.Sight(camera, 1, (box,), stamp))
    rig.store.announce()
    rig.hub.flush()
    rig.hub.beat()
    (sent,) = deltas(rig, lane)
    found = sent["detections"]
    assert found["camera"] == "head"  # type: ignore[index]
    assert found["t"] == pytest.approx((now_s - 0.1) * 1000)  # type: ignore[index]
    assert found["boxes"] == [  # type: ignore[index]
        {"kind": "obstacle", "x": 0.1, "y": 0.2, "w": 0.3, "h": 0.4, "score": 0.9, "hit": None}
    ]
    assert [one["camera"] for one in found["others"]] == ["rear"]  # type: ignore[index]
