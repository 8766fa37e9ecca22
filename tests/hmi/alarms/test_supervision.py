"""The console's own watching: what it finds, and what it must not call an alarm."""

from __future__ import annotations

from typing import Any, NamedTuple

import pytest

from backend_clients.edge import messages_up as up
from backend_clients.edge.machine import LastTransition
from hmi.domain.alarm.finding import Finding
from hmi.ingest.supervision.fence import Ground
from tests.hmi.alarms.rig import MARTHA, AlarmRig

ROBOT = "weeder-01"
OFF = up.ToolState(state="off")
SQUARE = [(5.0, 52.0), (5.002, 52.0), (5.002, 52.001), (5.0, 52.001), (5.0, 52.0)]


class Stored(NamedTuple):
    """What is known of a mission."""

    sha256: str = "a" * 64
    battery_share: float | None = 0.5
    duration_s: float | None = 3600.0


def order(**values: Any) -> up.OrderState:
    """Return a mission that runs."""
    body: dict[str, Any] = {"mission_id": "m-1", "revision": 1, "sha256": "a" * 64, "status": "running", "row": 3,
                            "rows": 10, "segment": 5, "segment_s_m": 2.0, "area_m2": 1000.0, "area_done_m2": 300.0,
                            "distance_m": 100.0, "remaining_s": 600.0, "is_supervised": True}  # fmt: skip
    return up.OrderState(**{**body, **values})


def codes(rig: AlarmRig) -> set[str]:
    """Return the types of all alarms."""
    return {one.alarm.key.code for one in rig.alarms.all()}


def work(rig: AlarmRig, seconds: int, *, mode: str = "auto", moves: bool = True, **telemetry: Any) -> None:
    """Let a mission run for a while; it moves on unless told otherwise."""
    for second in range(seconds):
        done = {"segment_s_m": 0.4 * second, "area_done_m2": 300.0 + second} if moves else {}
        rig.say(rig.wire().state(mode=mode, path=["Mission"], order=order(**done)))
        rig.run(1, ROBOT, **telemetry)


async def test_a_day_at_work_without_trouble_raises_nothing() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.missions["m-1"] = Stored()
        rig.ground = Ground.of([[SQUARE]])
        rig.say(rig.wire().safety())
        work(rig, 400, lat_deg=52.0005, lon_deg=5.001)
        assert rig.states() == {}


async def test_off_its_line_counts_after_a_second_and_ends_only_below_the_dead_band() -> None:
    async with AlarmRig(ROBOT) as rig:
        work(rig, 3, cross_track_m=0.149)
        assert codes(rig) == set()
        work(rig, 3, cross_track_m=-0.22)
        assert rig.one("off-track.weeder-01").alarm.text == "0.22 m to the right, limit 0.15 m."
        work(rig, 6, cross_track_m=0.12)
        assert rig.states()["off-track.weeder-01"] == "unacknowledged"
        work(rig, 6, cross_track_m=0.05)
        assert rig.states()["off-track.weeder-01"] == "returned"


async def test_a_mission_that_stands_still_is_stalled_and_says_what_it_waits_for() -> None:
    async with AlarmRig(ROBOT) as rig:
        work(rig, 118, moves=False)
        assert codes(rig) == set()
        hold = up.Hold(code="rtk_float", text="Its position is not exact.", clears="Wait.", who="operator")
        for _ in range(5):
            rig.say(rig.wire().state(mode="auto", path=["Mission"], order=order(), hold=hold))
            rig.run(1, ROBOT)
        assert "Its position is not exact." in rig.one("stalled.weeder-01").alarm.text


async def test_a_planter_that_stands_and_goes_from_state_to_state_is_not_stalled_until_it_stays_in_one() -> None:
    async with AlarmRig(ROBOT) as rig:
        robot = rig.wire()
        states = ("above-plant", "on-ground")
        for number in range(30):
            head = robot.head()
            step = LastTransition(source=states[number % 2], target=states[1 - number % 2], event="next",
                                  at_ms=head["mono_ms"])  # fmt: skip
            for _ in range(10):
                rig.say(robot.state(mode="auto", path=["Mission"], order=order(), last_transition=step))
                rig.run(1, ROBOT)
        assert "stalled.weeder-01" not in rig.states()
        work(rig, 130, moves=False)
        assert "stalled.weeder-01" in rig.states()


async def test_a_paused_mission_is_not_stalled() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.say(rig.wire().safety())
        work(rig, 200, mode="paused", moves=False, speed_mps=0.0, tool=OFF)
        assert codes(rig) == set()


def _work_slowly(rig: AlarmRig, seconds: int) -> None:
    for second in range(seconds):
        minute = second // 60
        rig.say(rig.wire().state(mode="auto", path=["Mission"],
                                 order=order(row=minute, area_done_m2=100.0 + 10 * minute)))  # fmt: skip
        rig.run(1, ROBOT)


async def test_a_mission_that_is_not_heard_is_not_called_stalled_and_silence_does_not_count() -> None:
    async with AlarmRig(ROBOT) as rig:
        work(rig, 60, moves=False)
        rig.run(600)
        assert codes(rig) == {"link-lost"}
        work(rig, 50, moves=False)
        assert codes(rig) == {"link-lost"}
        work(rig, 20, moves=False)
        assert rig.states()["stalled.weeder-01"] == "unacknowledged"


@pytest.mark.parametrize("moves", [False, True])
async def test_what_stood_still_before_the_restart_stays_until_it_is_seen_to_move(moves: bool) -> None:
    async with AlarmRig(ROBOT) as rig:
        work(rig, 130, moves=False)
        before = rig.one("stalled.weeder-01").alarm
    async with AlarmRig(ROBOT) as rig:
        rig.alarms.restore(before)
        rig.watch.restore(before)
        work(rig, 130, moves=moves)
        assert rig.states() == {"stalled.weeder-01": "returned" if moves else "unacknowledged"}
        assert len(rig.steps) == (1 if moves else 0)


async def test_what_was_slow_before_the_restart_stays_until_a_quarter_of_an_hour_was_seen() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.watch.report(ROBOT, "test", (Finding("behind-plan", "15.0 % of the field."),))
        before = rig.one("behind-plan.weeder-01").alarm
    async with AlarmRig(ROBOT) as rig:
        rig.missions["m-1"] = Stored(battery_share=None, duration_s=1800.0)
        rig.alarms.restore(before)
        rig.watch.restore(before)
        _work_slowly(rig, 910)
        assert rig.states() == {"behind-plan.weeder-01": "unacknowledged"}
        assert rig.steps == []


async def test_half_as_fast_as_planned_over_a_quarter_of_an_hour_is_told_with_both_figures() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.missions["m-1"] = Stored(battery_share=None, duration_s=1800.0)
        _work_slowly(rig, 910)
        assert rig.one("behind-plan.weeder-01").alarm.text.startswith(
            "15.0 % of the field in the last 15 min; planned 50"
        )


async def test_a_machine_outside_the_farm_is_an_alarm_only_while_it_moves_by_itself() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.ground = Ground.of([[SQUARE]])
        outside = {"lat_deg": 52.0005, "lon_deg": 5.00205}
        rig.say(rig.wire().state(mode="idle"))
        rig.run(5, ROBOT, **outside)
        assert codes(rig) == set()
        work(rig, 3, **outside)
        assert rig.one("outside-fence.weeder-01").alarm.text == "3.4 m outside the farm's edge."
        work(rig, 4, lat_deg=52.0005, lon_deg=5.0019)
        assert rig.states()["outside-fence.weeder-01"] == "returned"


async def test_the_fence_is_found_out_also_when_the_machine_jumps_far() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.ground = Ground.of([[SQUARE]])
        work(rig, 3, lat_deg=52.0005, lon_deg=5.001)
        work(rig, 3, lat_deg=52.0005, lon_deg=5.01)
        assert "outside-fence" in codes(rig)


POND = [(5.0009, 52.0004), (5.0011, 52.0004), (5.0011, 52.0006), (5.0009, 52.0006), (5.0009, 52.0004)]
EAST = [(lon + 0.01, lat) for lon, lat in SQUARE]
IN_POND = {"lat_deg": 52.0005, "lon_deg": 5.001}


@pytest.mark.parametrize("farms", [[[SQUARE]], []])
async def test_a_keep_out_zone_is_no_ground_to_be_on_with_or_without_a_farm_edge(farms: list[Any]) -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.ground = Ground.of(farms, [("keep-out zone Pond", [POND])])
        work(rig, 3, lat_deg=52.0005, lon_deg=5.0005)
        assert codes(rig) == set()
        work(rig, 3, **IN_POND)
        assert rig.one("outside-fence.weeder-01").alarm.text == "6.9 m inside keep-out zone Pond."
        work(rig, 4, lat_deg=52.0005, lon_deg=5.0005)
        assert rig.states()["outside-fence.weeder-01"] == "returned"


async def test_a_machine_at_the_rim_of_a_keep_out_zone_may_be_there_by_the_accuracy_of_its_position() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.ground = Ground.of([[SQUARE]], [("a keep-out zone", [POND])])
        work(rig, 3, lat_deg=52.0005, lon_deg=5.000905)  # 0.34 m
        assert codes(rig) == set()


async def test_a_hole_in_the_farm_is_not_its_ground_and_a_second_farm_is() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.ground = Ground.of([[SQUARE, POND], [EAST]])
        work(rig, 3, lat_deg=52.0005, lon_deg=5.011)
        assert codes(rig) == set()
        work(rig, 3, **IN_POND)
        assert rig.one("outside-fence.weeder-01").alarm.text == "6.9 m outside the farm's edge."


async def test_deep_in_two_zones_that_touch_is_not_at_their_rim() -> None:
    async with AlarmRig(ROBOT) as rig:
        other = [(lon + 0.0002, lat) for lon, lat in POND]
        rig.ground = Ground.of([[SQUARE]], [("keep-out zone Pond", [POND]), ("keep-out zone Bank", [other])])
        work(rig, 3, lat_deg=52.0005, lon_deg=5.001099)
        assert "outside-fence" in codes(rig)


def test_a_map_without_farm_and_zones_has_no_ground() -> None:
    assert Ground.of([]) is None
    assert Ground.of([[[(5.0, 52.0)] * 4]]) is None
    assert Ground.of([[SQUARE[:2]]]) is None


async def test_what_says_it_is_stopped_may_brake_and_then_must_not_move() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.say(rig.wire().factsheet())
        work(rig, 2, speed_mps=1.0)
        press = up.Press(stop_id="stop-00000001", by="Martha", device="Tablet 3", mono_ms=0)
        moving = {"latched": True, "standstill": False, "speed_mps": 1.0, "tool_off": True, "presses": [press]}
        rig.say(rig.wire().safety(**moving))
        rig.run(1, ROBOT, speed_mps=0.6, tool=OFF)
        assert codes(rig) == set()
        rig.say(rig.wire().safety(**moving))
        rig.run(4, ROBOT, speed_mps=0.6, tool=OFF)
        assert rig.one("moves-after-stop.weeder-01").priority == 1
        rig.say(rig.wire().safety(latched=True, presses=[press]))
        rig.run(3, ROBOT, speed_mps=0.0, tool=OFF)
        rig.alarms.acknowledge("moves-after-stop.weeder-01", MARTHA)
        assert rig.states() == {"moves-after-stop.weeder-01": "latched"}


@pytest.mark.parametrize("heard", [(), (ROBOT,)])
async def test_a_stopped_machine_last_heard_while_it_braked_is_not_said_to_move(heard: tuple[str, ...]) -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.say(rig.wire().factsheet())
        work(rig, 2, speed_mps=1.0)
        rig.say(rig.wire().safety(latched=True, standstill=False, speed_mps=0.8))
        rig.beat(speed_mps=0.8, tool=OFF)
        for _ in range(60):  # nothing more, or its voice alone
            rig.clock.advance(0.5)
            for robot_id in heard:
                rig.say(rig.wire(robot_id).heartbeat())
            rig.edge.look_after()
            rig.round()
        assert codes(rig) == {"values-old" if heard else "link-lost"}


async def test_a_stopped_machine_that_moved_on_before_it_fell_silent_keeps_its_alarm() -> None:
    async with AlarmRig(ROBOT) as rig:
        work(rig, 2, speed_mps=1.0)
        for _ in range(6):
            rig.say(rig.wire().safety(latched=True, standstill=False, speed_mps=0.6))
            rig.run(1, ROBOT, speed_mps=0.6, tool=OFF)
        assert rig.states() == {"moves-after-stop.weeder-01": "unacknowledged"}
        rig.run(30)
        assert rig.states()["moves-after-stop.weeder-01"] == "unacknowledged"


async def test_a_tool_last_seen_on_before_its_values_grew_old_is_not_called_a_contradiction() -> None:
    async with AlarmRig(ROBOT) as rig:
        work(rig, 3, speed_mps=0.4, tool=up.ToolState(state="on"))
        for half in range(12):
            rig.clock.advance(0.5)
            state = rig.wire().state(mode="auto" if half < 4 else "idle", order=order(segment_s_m=float(half)))
            for message in (rig.wire().heartbeat(), state, rig.wire().safety()):
                rig.say(message)
            rig.round()
        assert codes(rig) == {"values-old"}


async def test_a_stopped_machine_that_is_carried_off_without_speed_is_seen_by_its_place() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(1, ROBOT, speed_mps=0.0)
        for second in range(12):
            rig.say(rig.wire().safety(latched=True))
            rig.run(1, ROBOT, speed_mps=0.0, x_m=1.0 + max(0, second - 5) * 0.2)
        assert rig.one("moves-after-stop.weeder-01").alarm.text.startswith("It is stopped and was moved by")


async def test_paused_and_moving_is_a_contradiction() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.say(rig.wire().safety())
        work(rig, 5, mode="paused", speed_mps=0.4)
        assert rig.one("moves-unasked.weeder-01").alarm.text == "It says paused and moves at 0.4 m/s."


async def test_a_laser_that_is_on_while_a_person_drives_is_critical() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.say(rig.wire().safety(tool_off=False))
        work(rig, 3, mode="manual", tool=up.ToolState(state="on"))
        assert rig.one("tool-on-unasked.weeder-01").priority == 1


async def test_the_battery_is_judged_once_and_not_while_it_charges() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(8, ROBOT, battery=up.Battery(soc=0.08))
        assert codes(rig) == {"battery-very-low"}
        rig.run(8, ROBOT, battery=up.Battery(soc=0.08, charging=True))
        assert rig.states() == {"battery-very-low.weeder-01": "returned"}


async def test_a_robot_that_reports_the_same_as_the_console_sees_makes_one_alarm() -> None:
    async with AlarmRig(ROBOT) as rig:
        fault = up.Fault(code="battery-low", level="medium", text="The battery is below 20 %.", hint="Charge it.")
        rig.say(rig.wire().state(faults=[fault]))
        rig.run(3, ROBOT, battery=up.Battery(soc=0.15))
        assert rig.states() == {"battery-low.weeder-01": "unacknowledged"}


async def test_a_battery_that_does_not_last_is_told_with_what_is_needed() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.missions["m-1"] = Stored(battery_share=0.9)
        work(rig, 65, battery=up.Battery(soc=0.55))
        assert rig.one("battery-short.weeder-01").alarm.text.startswith("55 % now; the rest needs 5")


async def test_a_battery_that_lasts_for_hours_is_told_in_the_last_hour_before_its_reserve() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.missions["m-1"] = Stored(battery_share=0.9)
        work(rig, 65, battery=up.Battery(soc=0.55, remaining_s=8000.0))
        assert rig.states() == {}
        work(rig, 65, battery=up.Battery(soc=0.4, remaining_s=4000.0))
        assert set(rig.states()) == {"battery-short.weeder-01"}


async def test_each_failed_node_is_an_alarm_of_its_own() -> None:
    async with AlarmRig(ROBOT) as rig:
        for name in ("planner", "laser_driver", "camera"):
            rig.say(rig.wire().node(name=name, state="started" if name == "camera" else "failure", text="exit 139"))
        rig.run(1, ROBOT)
        assert set(rig.states()) == {"node-failed.weeder-01.planner", "node-failed.weeder-01.laser-driver"}


async def test_a_wrong_clock_is_an_alarm_and_a_slow_link_is_not() -> None:
    async with AlarmRig(ROBOT) as rig:
        for _ in range(45):
            rig.clock.advance(1)
            wall_ms = round(rig.clock.utc().timestamp() * 1000) + 60_000
            rig.say(rig.wire().heartbeat(wall_ms=wall_ms))
            rig.say(rig.wire().telemetry())
            rig.round()
        assert rig.one("clock-wrong.weeder-01").alarm.text == "60 s ahead of the console."


async def test_a_restarted_robot_is_told_once_and_stays_until_it_is_cleared() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(3, ROBOT)
        rig.wire().boot, rig.wire().booted_s = "boot-bbbb", rig.clock.mono_s()
        rig.run(8, ROBOT)
        assert rig.states() == {"restarted.weeder-01": "returned"}
        rig.alarms.acknowledge("restarted.weeder-01", MARTHA)
        assert rig.states() == {"restarted.weeder-01": "latched"}
        rig.alarms.clear("restarted.weeder-01", MARTHA)
        assert rig.states() == {}


async def test_a_rule_that_breaks_does_not_silence_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    async with AlarmRig(ROBOT) as rig:
        monkeypatch.setattr("hmi.ingest.supervision.battery.Battery.look", lambda _self, _view: 1 / 0)
        rig.run(2, ROBOT)
        rig.run(8)
        assert "link-lost" in codes(rig)


async def test_an_alarm_of_before_the_restart_stays_until_its_robot_proves_otherwise() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.watch.report(ROBOT, "stop", (Finding("stop-not-confirmed", "Martha pressed STOP."),))
        before = rig.one("stop-not-confirmed.weeder-01").alarm
    async with AlarmRig(ROBOT) as rig:
        rig.alarms.restore(before)
        rig.watch.restore(before)
        rig.run(10)
        assert rig.states() == {"stop-not-confirmed.weeder-01": "unacknowledged"}
        rig.say(rig.wire().safety(standstill=False, speed_mps=0.4, latched=True))
        rig.run(2, ROBOT)
        assert rig.states()["stop-not-confirmed.weeder-01"] == "unacknowledged"
        rig.say(rig.wire().safety(latched=True))
        assert rig.states()["stop-not-confirmed.weeder-01"] == "returned"


async def test_a_robot_taken_out_of_the_registry_leaves_no_standing_alarm() -> None:
    async with AlarmRig(ROBOT) as rig:
        rig.run(2, ROBOT)
        rig.run(8)
        rig.store.set_registry([])
        rig.run(4)
        assert rig.states() == {"link-lost.weeder-01": "returned"}
