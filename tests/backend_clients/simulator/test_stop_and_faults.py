"""STOP, its reset, the button on the machine, and every fault a tester can switch on."""

from __future__ import annotations

import errno
import random
from pathlib import Path

import pytest

from backend_clients.simulator import faults
from backend_clients.simulator.faults import Packets, decode_fault, fate
from backend_clients.simulator.kinematics import TRACKED
from backend_clients.simulator.latch import LatchMemory
from backend_clients.simulator.state_folder import SavedSafety, StateFolder
from tests.backend_clients.simulator.rig import Rig, small_mission


def running() -> Rig:
    rig = Rig()
    assert rig.start().outcome == "accepted"
    rig.run(7.5)
    assert rig.speed > 0.9
    return rig


def test_stop_brakes_within_the_distance_it_announces_and_switches_the_laser_off() -> None:
    rig = running()
    speed, before = rig.speed, rig.robot.machine.base.distance_m
    ack = rig.stop()
    assert (ack.outcome, ack.kind, ack.ref) == ("accepted", "stop", "stop-000001")
    assert ack.speed_mps == pytest.approx(speed)
    assert not rig.safety.standstill
    assert rig.safety.stopping_distance_m is None
    rig.run(0.05)
    assert not rig.robot.machine.tool_on
    rig.run(3)
    rolled_m = rig.robot.machine.base.distance_m - before
    assert rolled_m <= TRACKED.stopping_distance_m(speed) + speed * 0.05
    assert (rig.safety.standstill, rig.safety.latched, rig.state.mode) == (True, True, "stopped")
    assert rig.safety.stopping_distance_m == pytest.approx(rolled_m, abs=0.001)
    assert rolled_m > 0.1
    assert [p.stop_id for p in rig.safety.presses] == ["stop-000001"]


def test_standstill_is_told_only_after_half_a_second_without_motion() -> None:
    rig = running()
    rig.stop()
    while rig.speed > 0:
        rig.run(0.05)
    rig.run(0.4)
    assert not rig.safety.standstill
    rig.run(0.15)
    assert rig.safety.standstill


def test_nothing_moves_while_a_stop_is_latched() -> None:
    rig = running()
    rig.stop()
    rig.run(3)
    rig.token += 1
    mission_id = small_mission().mission_id
    for action in ("start", "resume", "return_home", "drive_open"):
        ack = rig.do(action, mission_id=mission_id)
        assert (ack.outcome, ack.code) == ("rejected", "stop_latched"), action
    before = rig.robot.machine.base.distance_m
    rig.run(5)
    assert rig.robot.machine.base.distance_m == before


def test_a_stop_ends_the_lease_that_was_in_force() -> None:
    rig = running()
    rig.stop()
    assert rig.state.lease_token == 0
    rig.run(3)
    assert rig.do("resume").code == "lease_revoked"


def test_repeats_of_a_stop_do_not_end_the_next_lease() -> None:
    rig = running()
    rig.stop()
    rig.run(3)
    rig.token += 1
    rig.pulse()
    assert rig.stop().code == "already_latched"
    assert rig.state.lease_token == rig.token


def test_a_reset_leaves_the_robot_paused_and_moves_nothing() -> None:
    rig = running()
    rig.stop()
    rig.run(3)
    assert rig.reset().outcome == "accepted"
    before = rig.robot.machine.base.distance_m
    rig.run(5)
    assert (rig.state.mode, rig.safety.latched) == ("paused", False)
    assert rig.robot.machine.base.distance_m == before
    assert rig.do("resume").outcome == "accepted"


def test_a_reset_is_refused_before_standstill() -> None:
    rig = running()
    rig.stop()
    rig.run(0.1)
    assert rig.reset().code == "not_standing"
    assert rig.safety.latched


def test_a_reset_is_refused_while_the_button_on_the_machine_is_pressed() -> None:
    rig = running()
    rig.robot.set_fault(faults.HardwareStop())
    rig.stop()
    rig.run(3)
    assert rig.reset().code == "hardware_stop"


def test_each_press_needs_its_own_reset() -> None:
    rig = running()
    rig.stop("stop-aaaaaa")
    rig.stop("stop-bbbbbb")
    rig.run(3)
    assert rig.reset("stop-aaaaaa").code == "still_latched"
    assert rig.safety.latched
    assert [(p.stop_id, p.is_reset) for p in rig.safety.presses] == [("stop-aaaaaa", True), ("stop-bbbbbb", False)]
    assert rig.reset("stop-unknown").code == "unknown_stop"
    assert rig.reset("stop-bbbbbb").code == "ok"
    assert not rig.safety.latched


def test_a_late_copy_of_a_stop_that_was_reset_does_not_latch_even_after_a_reboot(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.stop()
    rig.run(1)
    rig.reset()
    assert rig.stop().code == "already_reset"
    rig.restart_process()
    assert (rig.stop().code, rig.safety.latched) == ("already_reset", False)


def test_a_latched_stop_and_the_end_of_the_lease_survive_a_reboot(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.start()
    rig.run(5)
    rig.stop()
    rig.restart_process()
    rig.run(2)
    assert (rig.safety.latched, rig.state.mode) == (True, "stopped")
    assert rig.do("resume").code == "lease_revoked"


def test_an_unreadable_latch_file_counts_as_latched(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.stop()
    (tmp_path / "safety.json").write_text("{broken")
    rig.restart_process()
    rig.run(1)
    assert rig.safety.latched
    assert rig.reset(rig.safety.presses[0].stop_id).code == "ok"


def test_a_full_disk_stops_no_robot_and_a_stop_latches_over_a_reboot_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = Rig(tmp_path)
    rig.start()
    rig.run(5)
    with monkeypatch.context() as disk:
        disk.setattr(Path, "write_bytes", full)
        before_m = rig.robot.machine.base.distance_m
        rig.run(5)
        assert rig.robot.machine.base.distance_m > before_m
        rig.stop()
        rig.run(2)
        rig.restart_process()
        rig.run(1)
        assert rig.safety.latched
        assert rig.reset(rig.safety.presses[0].stop_id).code == "ok"
    assert not rig.safety.latched


def test_what_a_full_disk_did_not_take_is_written_when_there_is_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store, mission = StateFolder(tmp_path), small_mission()
    with monkeypatch.context() as disk:
        disk.setattr(Path, "write_bytes", full)
        store.save_mission(mission)
        assert store.load_mission() == mission
    assert StateFolder(tmp_path).load_mission() is None
    store.save_safety(SavedSafety(latch=LatchMemory()))
    assert StateFolder(tmp_path).load_mission() == mission


def full(path: Path, _data: bytes) -> int:
    raise OSError(errno.ENOSPC, "No space left on device", str(path))


def test_the_button_on_the_machine_stops_it_and_its_release_leaves_it_paused() -> None:
    rig = running()
    rig.robot.set_fault(faults.HardwareStop())
    rig.run(3)
    assert (rig.state.mode, rig.speed, rig.safety.hardware_stop) == ("stopped", 0, True)
    rig.robot.clear_fault("hardware-stop")
    rig.run(5)
    assert (rig.state.mode, rig.speed) == ("paused", 0)


def test_a_person_ahead_is_waited_for_and_then_the_horn_sounds_again() -> None:
    rig = Rig()
    rig.start(small_mission(length_m=30))
    rig.run(12)
    rig.robot.set_fault(faults.PersonAhead(distance_m=3.0))
    rig.run(3)
    free_m = rig.telemetry.obstacle_m
    assert rig.state.hold is not None
    assert (rig.speed, rig.state.hold.code, rig.state.mode) == (0, "person_ahead", "auto")
    assert free_m is not None
    assert free_m > 0.5
    assert [f.code for f in rig.state.faults] == ["person-ahead"]
    rig.robot.clear_fault("person-ahead")
    rig.run(2.5)
    assert rig.state.hold is not None
    assert (rig.speed, rig.state.hold.code) == (0, "start_horn")
    rig.run(2)
    assert rig.speed > 0.5
    kinds = [(e.kind, e.name) for e in rig.events]
    assert ("alarm_raised", "person-ahead") in kinds
    assert ("alarm_cleared", "person-ahead") in kinds


def test_by_hand_it_does_not_set_off_when_the_person_leaves_but_when_the_hand_presses_again() -> None:
    rig = Rig()
    rig.do("drive_open")
    rig.run(0.6)
    rig.drive_for(1.0, v_mps=0.4)
    assert rig.speed > 0.2
    rig.robot.set_fault(faults.PersonAhead(distance_m=1.0))
    rig.drive_for(2.0, v_mps=0.4)
    assert rig.state.hold is not None
    assert (rig.speed, rig.state.hold.code) == (0, "way_blocked")
    rig.drive_for(1.0, v_mps=-0.2)
    assert rig.speed < -0.05, "it may back away"
    rig.drive_for(1.0, v_mps=0.4)
    rig.robot.clear_fault("person-ahead")
    rig.drive_for(1.0, v_mps=0.4)
    assert (rig.speed, rig.state.hold and rig.state.hold.code) == (0, "way_blocked")
    rig.drive_for(0.2, v_mps=0.0)
    rig.drive_for(1.0, v_mps=0.4)
    assert rig.speed > 0.2


@pytest.mark.parametrize(
    ("fault", "hold", "refusal"),
    [
        (faults.RtkFloat(), "rtk_float", "gnss_not_fixed"),
        (faults.ToolInterlock(), "tool_interlock", "tool_interlock"),
        (faults.LowBattery(soc=0.05), "battery_low", "battery_low"),
    ],
)
def test_a_machine_that_cannot_weed_waits_and_refuses_a_start(fault: faults.Fault, hold: str, refusal: str) -> None:
    rig = running()
    rig.robot.set_fault(fault)
    rig.run(3)
    assert rig.state.hold is not None
    assert (rig.speed, rig.robot.machine.tool_on, rig.state.hold.code) == (0, False, hold)
    rig.do("abort")
    assert rig.do("start", mission_id="mission-1").code == refusal


def test_a_rejecting_robot_refuses_commands_but_never_a_stop() -> None:
    rig = running()
    rig.robot.set_fault(faults.Reject())
    assert rig.do("pause").code == "simulated_reject"
    assert rig.stop().outcome == "accepted"


def test_a_robot_with_broken_brakes_acknowledges_and_says_honestly_that_it_moves() -> None:
    rig = running()
    rig.robot.set_fault(faults.KeepsMoving())
    assert rig.stop().outcome == "accepted"
    rig.run(3)
    assert rig.speed > 0.5
    assert (rig.safety.latched, rig.safety.standstill) == (True, False)
    assert rig.safety.speed_mps > 0.5
    rig.robot.clear_fault("keeps-moving")
    rig.run(3)
    assert rig.safety.standstill


def test_a_crash_stops_the_machine_and_a_reboot_has_a_new_id_and_does_not_move() -> None:
    rig = running()
    boot = rig.state.boot
    rig.robot.set_fault(faults.Crash(reboot_after_s=2.0))
    rig.run(1.95)
    assert rig.robot.boot is None
    rig.run(3)
    assert rig.state.boot != boot
    assert (rig.state.mode, rig.speed, rig.robot.machine.tool_on) == ("paused", 0, False)
    assert rig.state.hold is not None
    assert rig.state.hold.code == "rebooted"


def test_a_wrong_wall_clock_changes_nothing_but_the_time_shown() -> None:
    rig = running()
    rig.robot.set_fault(faults.WallClock(offset_s=-7200))
    rig.clock.jump_wall(86400)
    assert rig.state.wall_ms == pytest.approx((rig.clock.utc().timestamp() - 7200) * 1000, abs=2)
    assert rig.do("pause").outcome == "accepted"


def test_faults_are_described_by_name_and_nonsense_is_refused() -> None:
    assert decode_fault(b'{"fault":"silence","http":true}') == faults.Silence(http=True)
    with pytest.raises(ValueError):
        decode_fault(b'{"fault":"fire"}')
    with pytest.raises(ValueError):
        decode_fault(b'{"fault":"packets","drop":2}')


def test_a_bad_network_loses_delays_and_doubles_as_told() -> None:
    rng = random.Random(3)
    assert fate(None, "up", rng) == [0.0]
    assert fate(Packets(direction="down", drop=1.0), "up", rng) == [0.0]
    assert fate(Packets(drop=1.0), "up", rng) == []
    assert fate(Packets(duplicate=1.0, delay_s=0.5), "up", rng) == [0.5, 0.5]
    lost = sum(not fate(Packets(drop=0.3), "up", rng) for _ in range(2000))
    assert 480 < lost < 720
