"""Orders to crane, seedlings and nodes obey STOP, control and freshness as every order does."""

from __future__ import annotations

import math

import pytest

from backend_clients.simulator.crane import BY_NAME, TRANSPORT
from backend_clients.simulator.faults import CraneLimit, NodeFailure, PersonAhead, TrayEmpty
from backend_clients.simulator.joint_travel import travel_share
from backend_clients.simulator.planter_rig import PlanterRig
from backend_clients.simulator.terrain import height_m
from tests.backend_clients.simulator.rig import Rig, small_mission
from tests.backend_clients.simulator.test_families import until

AT_SITE = {"length_m": 12.0, "width_m": 4.0}
BESIDE = (4.0, -4.0, 0.5)  # of a machine that stands at (0, -2) and looks north


def planter() -> Rig:
    """Return a planter that stands with its crane folded."""
    rig = Rig(family="planter")
    rig.pulse()
    return rig


def machine(rig: Rig) -> PlanterRig:
    """Return its crane and what hangs on it."""
    found = rig.robot.machine.rig
    assert found is not None
    return found


def at_work() -> Rig:
    """Return a planter whose crane is on its way to a point."""
    rig = planter()
    rig.start(small_mission(**AT_SITE))
    until(rig, lambda: "above-plant" in active(rig), 120.0)
    rig.run(2.0)
    return rig


def active(rig: Rig) -> list[str]:
    """Return the active states."""
    return [one.id for one in rig.state.active]


def pose(rig: Rig) -> dict[str, float]:
    """Return the joints as measured."""
    return dict(rig.boot.reporter.body().joints)


@pytest.mark.parametrize("action", ["tool_retract", "tool_go_to", "skip_target", "stock_refilled", "go_to"])
def test_what_can_move_the_machine_needs_control_a_fresh_challenge_and_no_stop(action: str) -> None:
    rig = planter()
    rig.run(0.2)
    more = {"place": BESIDE} if action in ("tool_go_to", "go_to") else {}
    rig.token = 3
    rig.do("drive_open")
    rig.do("drive_close")
    assert rig.do(action, lease_token=2, **more).code == "old_lease"
    late = rig.order(action, **more)
    rig.run(2.5)
    answer = rig.robot.receive(late)
    assert answer is not None
    assert answer.code == "stale_challenge"
    rig.stop()
    rig.token = 5
    assert rig.do(action, **more).code == "stop_latched"


def test_the_tip_goes_where_it_is_sent_up_across_and_down_after_the_horn() -> None:
    rig = planter()
    assert rig.do("tool_go_to", place=BESIDE).outcome == "accepted"
    rig.run(2.5)
    assert pose(rig) == pytest.approx(TRANSPORT)
    rig.run(1.5)
    assert active(rig) == ["move-crane"]
    assert (rig.state.mode, rig.safety.standstill) == ("auto", False)
    until(rig, lambda: rig.state.mode == "idle", 60.0)
    tool = rig.boot.reporter.body().tool
    assert tool is not None
    assert math.dist(tool[:2], BESIDE[:2]) < 0.01
    ground_m = height_m(0.0, -2.0)
    assert abs(ground_m) > 0.05, "the machine does not stand at the height of the datum"
    assert tool[2] - ground_m == pytest.approx(BESIDE[2], abs=0.01), "above the ground it stands on"
    assert rig.do("tool_go_to", place=(60.0, 0.0, 0.0)).code == "out_of_reach"
    assert rig.do("go_to", place=BESIDE).outcome == "accepted"
    until(rig, lambda: rig.speed > 0.1, 60.0)
    assert pose(rig) == pytest.approx(TRANSPORT), "it folds the crane before it drives"


@pytest.mark.parametrize("end", ["stop", "pause", "nobody", "button"])
def test_stop_pause_a_lost_operator_and_the_button_hold_crane_and_drive_at_once(end: str) -> None:
    rig = at_work()
    before = pose(rig)
    rig.run(0.2)
    assert pose(rig) != before
    if end == "stop":
        rig.stop()
    elif end == "pause":
        rig.do("pause")
    elif end == "button":
        rig.robot.machine.is_hardware_stop = True
        rig.run(0.05)
    else:
        rig.has_page = False
        until(rig, lambda: rig.state.mode == "paused", 6.0)
    held = pose(rig)
    rig.run(5.0)
    assert pose(rig) == held
    assert rig.speed == 0
    assert rig.safety.standstill
    assert rig.state.mode in ("paused", "stopped")


def test_after_a_stop_in_the_middle_the_seedling_is_still_held_and_planted_after_a_resume() -> None:
    rig = at_work()
    rig.stop()
    rig.run(3.0)
    assert machine(rig).in_head == 1
    rig.reset()
    rig.run(1.0)
    taken = rig.robot.machine.seedlings
    assert rig.do("resume").outcome == "accepted"
    until(rig, lambda: "plant" in active(rig), 60.0)
    assert rig.robot.machine.seedlings == taken


def test_jogging_needs_open_driving_by_hand_and_ends_half_a_second_after_the_last_setpoint() -> None:
    rig = planter()
    refused = rig.jog(slew=0.2)
    assert refused is not None
    assert refused.code == "not_in_manual"
    rig.do("drive_open")
    rig.run(0.6)
    rig.jog_for(1.0, slew=0.2)
    assert pose(rig)["slew"] == pytest.approx(0.2, abs=0.02)
    assert (rig.safety.tool_off, rig.safety.standstill) == (True, False)
    rig.run(0.6)
    held = pose(rig)
    rig.run(1.0)
    assert pose(rig) == held
    rig.jog_for(0.3, slew=0.2)
    rig.stop()
    held = pose(rig)
    rig.run(1.0)
    assert pose(rig) == held
    rig.token += 1
    refused = rig.jog(slew=0.2)
    assert refused is not None
    assert refused.code == "stop_latched"


def test_a_soft_limit_slows_what_goes_out_and_a_limit_stops_it() -> None:
    rig = planter()
    rig.do("drive_open")
    joint = BY_NAME["telescope"]
    assert joint.soft_upper is not None
    until_s = 0.0
    while pose(rig)["telescope"] < joint.soft_upper:
        rig.jog_for(0.5, telescope=2.0)
        until_s += 0.5
        assert until_s < 20
    before = pose(rig)["telescope"]
    rig.jog_for(0.2, telescope=2.0)
    assert pose(rig)["telescope"] - before == pytest.approx(0.2 * joint.max_rate * 0.25, abs=0.02)
    assert "crane-limit" in [fault.code for fault in rig.state.faults]
    rig.jog_for(6.0, telescope=2.0)
    assert pose(rig)["telescope"] == joint.upper
    rig.jog_for(0.5, telescope=-2.0)
    assert pose(rig)["telescope"] == pytest.approx(joint.upper - 0.5 * joint.max_rate, abs=0.05)


def head(rig: Rig) -> dict[str, float]:
    assert rig.robot.machine.limbs is not None
    return rig.robot.machine.limbs.pose


def test_a_camera_head_obeys_the_hand_stays_there_and_looks_ahead_again_afterwards() -> None:
    weeder = Rig()
    weeder.run(1.0)
    assert head(weeder) == {"pan": 0.0, "tilt": -0.2}
    weeder.do("drive_open")
    weeder.run(0.6)
    weeder.jog_for(1.0, pan=0.4, tilt=-0.3)
    assert head(weeder)["pan"] == pytest.approx(0.4, abs=0.05)
    assert head(weeder)["tilt"] == pytest.approx(-0.5, abs=0.05)
    weeder.run(0.6)
    held = dict(head(weeder))
    weeder.run(2.0)
    assert head(weeder) == held
    weeder.jog_for(9.0, tilt=-1.0)
    assert head(weeder)["tilt"] == -0.9
    weeder.do("drive_close")
    weeder.run(4.0)
    assert head(weeder) == {"pan": 0.0, "tilt": -0.2}


def test_a_stop_holds_the_camera_head_where_it_is() -> None:
    weeder = Rig()
    weeder.do("drive_open")
    weeder.run(0.6)
    weeder.jog_for(0.5, pan=0.4)
    weeder.stop()
    held = dict(head(weeder))
    weeder.run(3.0)
    assert head(weeder) == held


def test_an_unknown_joint_and_a_machine_without_joints_refuse_to_jog() -> None:
    rig = planter()
    rig.do("drive_open")
    refused = rig.jog(nose=0.1)
    assert refused is not None
    assert refused.code == "unknown_joint"
    weeder = Rig(is_lean=True)
    weeder.do("drive_open")
    answer = weeder.jog(pan=0.1)
    assert answer is not None
    assert answer.code == "not_supported"
    weeder.do("drive_close")
    assert weeder.do("tool_retract").code == "not_supported"


def test_retracting_helps_a_mission_that_waits_for_its_crane_and_it_goes_on_after_the_horn() -> None:
    rig = planter()
    rig.start(small_mission(**AT_SITE))
    rig.run(5.0)
    rig.robot.set_fault(CraneLimit())
    rig.run(1.0)
    assert rig.state.hold is not None
    assert rig.state.hold.code == "crane_limit"
    assert travel_share(BY_NAME["stick"], pose(rig)["stick"]) == pytest.approx(0.97, abs=0.001)
    assert rig.do("tool_retract").outcome == "accepted"
    until(rig, lambda: "crane-limit" not in [f.code for f in rig.state.faults], 60.0)
    until(rig, lambda: rig.speed > 0.2, 30.0)
    assert rig.state.mode == "auto"


def test_a_working_mission_has_to_be_paused_before_the_crane_is_moved_alone() -> None:
    rig = at_work()
    assert rig.do("tool_retract").code == "mission_running"
    assert rig.do("go_to", place=BESIDE).code == "mission_running"
    rig.do("pause")
    rig.run(1.0)
    assert rig.do("tool_retract").outcome == "accepted"
    until(rig, lambda: rig.state.mode == "paused", 60.0)
    assert pose(rig) == pytest.approx(TRANSPORT)


def test_a_skipped_tree_is_left_out_and_the_next_one_gets_its_seedling() -> None:
    rig = at_work()
    site = machine(rig).site
    assert site is not None
    assert site.current is not None
    left_out, taken = site.current.id, rig.robot.machine.seedlings
    assert rig.do("skip_target").outcome == "accepted"
    until(rig, lambda: "plant" in active(rig), 120.0)
    assert next(one.status for one in site.targets if one.id == left_out) == "skipped"
    assert rig.robot.machine.seedlings == taken
    assert rig.do("skip_target").code == "too_late"
    rig.run(9.0)
    assert rig.do("skip_target").code == "no_target"


def test_a_named_tree_is_skipped_only_while_it_is_worked_at() -> None:
    rig = at_work()
    site = machine(rig).site
    assert site is not None
    assert site.current is not None
    first = site.current.id
    assert rig.do("skip_target", target="tree-999").code == "other_target"
    assert site.current.id == first
    assert rig.do("skip_target", target=first).outcome == "accepted"
    assert rig.do("skip_target", target=first).code in ("other_target", "no_target")


def test_a_loaded_tray_lets_the_mission_go_on() -> None:
    rig = planter()
    rig.start(small_mission(**AT_SITE))
    rig.robot.set_fault(TrayEmpty())
    until(rig, lambda: rig.state.hold is not None and rig.state.hold.code == "tray_empty", 60.0)
    assert rig.do("stock_refilled").outcome == "accepted"
    until(rig, lambda: "transfer" in active(rig), 60.0)


def test_somebody_near_slows_the_crane_and_somebody_within_its_reach_stops_it() -> None:
    rig = at_work()
    before = machine(rig).crane.tip
    rig.run(1.0)
    usual_m = math.dist(before, machine(rig).crane.tip)
    rig.robot.set_fault(PersonAhead(distance_m=9.0))
    rig.run(0.2)
    before = machine(rig).crane.tip
    rig.run(1.0)
    assert "person-near" in active(rig)
    assert math.dist(before, machine(rig).crane.tip) == pytest.approx(usual_m / 2, rel=0.35)
    rig.robot.set_fault(PersonAhead(distance_m=2.0))
    rig.run(0.2)
    held = pose(rig)
    rig.run(3.0)
    assert pose(rig) == held
    assert "person-inside" in active(rig)
    assert rig.boot.reporter.body().seen[0].kind == "person"
    rig.robot.clear_fault()
    rig.run(2.0)
    assert pose(rig) == held  # the horn first
    rig.run(3.0)
    assert pose(rig) != held


def test_a_failed_node_pauses_the_mission_and_an_admin_restarts_it_without_control() -> None:
    rig = at_work()
    rig.robot.set_fault(NodeFailure(node="crane"))
    held = pose(rig)
    rig.run(1.0)
    assert pose(rig) == held
    hold = rig.state.hold
    assert hold is not None
    assert (rig.state.mode, hold.code) == ("paused", "function_off")
    assert hold.text == "Plant trees is off: Crane controller does not run."
    assert rig.do("resume").text == "Plant trees is off: Crane controller does not run."
    nodes = {node.name: node for node in rig.boot.reporter.nodes()}
    assert (nodes["crane"].state, nodes["crane"].restarts) == ("failure", 0)
    assert rig.do("node_restart", node="crane", lease_token=0, lease_seq=0).outcome == "accepted"
    states = set()
    for _ in range(40):
        rig.run(0.1)
        states.add(next(node.state for node in rig.boot.reporter.nodes() if node.name == "crane"))
    assert states == {"starting", "started"}
    assert rig.state.mode == "paused", "a node that is back moves nothing"
    rig.run(6.0)  # what starts after it is restarted, in order
    nodes = {node.name: node for node in rig.boot.reporter.nodes()}
    since = [nodes[name].since_ms or 0 for name in ("drive", "crane", "planter", "supervisor")]
    assert since == sorted(since)
    assert [nodes[name].restarts for name in ("drive", "crane", "planter", "supervisor")] == [0, 1, 1, 1]
    assert rig.state.hold is not None
    assert rig.state.hold.text == "Paused by itself: a part of its software did not run."
    assert rig.do("resume").outcome == "accepted"


def test_a_crash_in_the_middle_of_a_movement_leaves_the_crane_standing() -> None:
    rig = at_work()
    held = pose(rig)
    rig.robot.crash(2.0)
    rig.run(1.0)
    assert rig.robot.machine.is_standing
    rig.run(3.0)
    assert pose(rig) == held
    assert rig.state.mode == "paused"
    assert rig.do("resume").outcome == "accepted"
    until(rig, lambda: "plant" in active(rig), 90.0)
    assert machine(rig).stops == 1


def test_a_planter_that_was_driven_on_by_hand_starts_from_where_it_stands_now() -> None:
    rig = at_work()
    rig.do("pause")
    rig.run(1.0)
    rig.do("tool_retract")
    until(rig, lambda: rig.state.mode == "paused", 60.0)
    rig.do("drive_open")
    rig.drive_for(6.0, 0.5)
    rig.drive_for(1.0, 0.0)
    rig.do("drive_close")
    assert rig.do("resume").code == "moved_while_paused"
    mission = small_mission(**AT_SITE)
    assert rig.start(mission).outcome == "accepted"
    until(rig, lambda: machine(rig).stops == 2, 120.0)
    site = machine(rig).site
    assert site is not None
    until(rig, lambda: site.planted > 0, 400.0)


def test_a_node_of_a_moving_robot_cannot_be_stopped_and_one_that_needs_others_waits_for_them() -> None:
    rig = at_work()
    assert rig.do("node_stop", node="gnss", lease_token=0, lease_seq=0).code == "not_standing"
    assert rig.do("node_restart", node="gnss", lease_token=0, lease_seq=0).code == "not_standing"
    rig.do("pause")
    rig.run(1.0)
    assert rig.do("node_stop", node="stereo", lease_token=0, lease_seq=0).outcome == "accepted"
    rig.run(1.0)
    assert rig.do("node_stop", node="person-guard", lease_token=0, lease_seq=0).outcome == "accepted"
    rig.run(1.0)
    assert rig.do("node_start", node="person-guard", lease_token=0, lease_seq=0).code == "starts_after"
    assert rig.do("node_start", node="stereo", lease_token=0, lease_seq=0).outcome == "accepted"
    assert rig.do("node_start", node="nobody", lease_token=0, lease_seq=0).code == "unknown_node"
    late = rig.order("node_stop", node="gnss", lease_token=0, lease_seq=0)
    rig.run(3.0)
    answer = rig.robot.receive(late)
    assert answer is not None
    assert answer.code == "stale_challenge"


def test_a_log_can_be_read_by_node() -> None:
    rig = at_work()
    journal = rig.boot.brain.journal
    crane = journal.tail(50, "crane").splitlines()
    assert crane
    assert all("[crane]" in line for line in crane)
    assert "[supervisor]" in journal.tail(50)
