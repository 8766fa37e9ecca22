"""Continue, resume later, start fresh, and a rest that changes: nothing done twice, nothing lost."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from backend_clients.edge import messages_down as down
from backend_clients.edge.codec import mission_hash
from tests.backend_clients.simulator.rig import Rig, small_mission

ROWS = 3


def order(rig: Rig) -> Any:
    found = rig.state.order
    assert found is not None
    return found


def into_row(rig: Rig, row: int, at_least_m: float = 2.0) -> None:
    for _ in range(4000):
        if order(rig).row == row and order(rig).segment_s_m >= at_least_m and rig.state.path[-1] == "Laser firing":
            return
        rig.run(0.1)
    raise AssertionError(f"never {at_least_m} m into row {row}: {rig.state}")


def finish(rig: Rig) -> None:
    for _ in range(800):
        if order(rig).status == "done":
            return
        rig.run(0.5)
    raise AssertionError(f"never done: {rig.state}")


def point_along(segment: down.Segment, s_m: float) -> tuple[float, float]:
    (ax, ay), (bx, by) = segment.points[0], segment.points[-1]
    share = s_m / math.dist(segment.points[0], segment.points[-1])
    return ax + share * (bx - ax), ay + share * (by - ay)


def cut(mission: down.Mission, segment: int, s_m: float) -> tuple[list[down.Segment], list[down.Segment]]:
    """Cut a straight segment in two."""
    whole = mission.segments[segment]
    there = point_along(whole, s_m)
    head = [*mission.segments[:segment], replace(whole, points=[whole.points[0], there])]
    return head, [replace(whole, points=[there, whole.points[-1]]), *mission.segments[segment + 1 :]]


def going_on(mission: down.Mission, head: list[down.Segment], rest: list[down.Segment], **more: Any) -> down.Mission:
    continues = down.Continues(base_sha256=mission_hash(mission), segments=len(head))
    return replace(mission, revision=mission.revision + 1, segments=[*head, *rest], continues=continues, **more)


def taken_up(rig: Rig, mission: down.Mission) -> down.Mission:
    """Return the mission from where it was interrupted, with a straight way there from where the robot stands."""
    now = order(rig)
    head, rest = cut(mission, now.segment, now.segment_s_m)
    x, y = rig.robot.machine.base.x_m, rig.robot.machine.base.y_m
    way = down.Segment(kind="approach", points=[(x, y), rest[0].points[0]], speed_mps=1.0, jump=True)
    return going_on(mission, head, [way, *rest])


def treated_m(rig: Rig) -> dict[int, float]:
    """Return the length treated in each row, from the robot's own events."""
    found: dict[int, float] = {}
    for event in rig.events:
        if event.kind == "treatment":
            found[event.data["row"]] = found.get(event.data["row"], 0.0) + event.data["length_m"]
    return found


def carry_to(rig: Rig, x_m: float, y_m: float) -> None:
    base = rig.robot.machine.base
    base.x_m, base.y_m = x_m, y_m


def without_row(mission: down.Mission, row: int) -> down.Mission:
    """Return an update that leaves out the last row, joined at the end of the row before."""
    at = next(i for i, one in enumerate(mission.segments) if one.row == row)
    return going_on(mission, list(mission.segments[: at - 1]), [
        down.Segment(kind="exit", points=[mission.segments[at - 2].points[-1], (1.0, -1.0)], speed_mps=1.0)
    ])  # fmt: skip


def test_a_mission_aborted_inside_a_row_is_taken_up_from_elsewhere_and_treats_every_row_once() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 2)
    rig.do("abort")
    rig.run(2)
    carry_to(rig, -4.0, 3.0)
    before = order(rig)
    update = taken_up(rig, mission)
    ack = rig.load(update)
    assert (ack.outcome, ack.sha256) == ("accepted", mission_hash(update))
    rig.run(5)
    assert (rig.robot.machine.base.x_m, order(rig).status) == (-4.0, "paused")
    assert rig.state.hold is not None
    assert rig.state.hold.code == "continued"
    assert order(rig).area_done_m2 == pytest.approx(before.area_done_m2, abs=0.1)
    assert rig.do("resume").outcome == "accepted"
    finish(rig)
    lengths = treated_m(rig)
    assert set(lengths) == {1, 2, 3}
    for length in lengths.values():
        assert length == pytest.approx(12.0, abs=0.35)


def test_the_laser_is_off_on_the_way_back_to_the_row() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 1, 6.0)
    rig.do("abort")
    rig.run(2)
    carry_to(rig, -6.0, 3.0)
    rig.load(taken_up(rig, mission))
    rig.do("resume")
    for _ in range(60):
        rig.run(0.1)
        if rig.robot.machine.base.x_m < -0.6:
            assert not rig.robot.machine.tool_on


def test_another_mission_in_between_does_not_lose_what_was_done() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 2)
    rig.do("abort")
    rig.run(2)
    update = taken_up(rig, mission)
    done_m2 = order(rig).area_done_m2
    other = small_mission(mission_id="mission-2", rows=1)
    rig.load(other)
    assert order(rig).mission_id == "mission-2"
    assert rig.load(update).outcome == "accepted"
    assert order(rig).area_done_m2 == pytest.approx(done_m2, abs=2.0)
    assert order(rig).row == 2


def test_a_battery_swap_keeps_the_place_and_a_carried_robot_counts_as_moved(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 2)
    carry_to(rig, 20.0, 20.0)
    base = rig.robot.machine.base
    rig.restart_process()
    carry_to(rig, base.x_m, base.y_m)
    rig.run(1)
    ack = rig.do("resume")
    assert (ack.outcome, ack.code) == ("rejected", "moved_while_paused")
    assert "Resume later" in ack.text
    assert rig.load(taken_up(rig, mission)).outcome == "accepted"
    assert rig.do("resume").outcome == "accepted"


def test_a_running_robot_takes_a_new_rest_without_stopping() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 1, 4.0)
    update = without_row(mission, 3)
    before = order(rig)
    assert rig.load(update).outcome == "accepted"
    rig.run(0.3)
    assert rig.speed > 1.0
    assert order(rig).sha256 == mission_hash(update)
    assert order(rig).segment_s_m >= before.segment_s_m
    finish(rig)
    assert set(treated_m(rig)) == {1, 2}


@pytest.mark.parametrize(
    ("proof", "code"),
    [
        ({"lease_token": 0}, "no_lease"),
        ({"lease_seq": 0}, "out_of_order"),
        ({"challenge": "nobody-sent-this"}, "stale_challenge"),
    ],
)
def test_a_robot_that_drives_is_not_redirected_late_or_without_control(proof: dict[str, Any], code: str) -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 1, 4.0)
    update = replace(without_row(mission, 3), proof=rig.proof(**proof))
    ack = rig.robot.receive(update)
    assert ack is not None
    assert (ack.outcome, ack.code) == ("rejected", code)
    assert order(rig).sha256 == mission_hash(mission)


def test_an_update_that_was_held_up_on_its_way_is_refused() -> None:
    rig = Rig()
    mission = small_mission(length_m=60.0)
    rig.start(mission)
    into_row(rig, 1, 2.0)
    update = replace(without_row(mission, 3), proof=rig.proof())
    rig.run(2.5)
    ack = rig.robot.receive(update)
    assert ack is not None
    assert (ack.outcome, ack.code) == ("rejected", "stale_challenge")
    assert order(rig).sha256 == mission_hash(mission)


def test_without_a_proof_only_a_robot_that_stands_takes_an_update() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 1, 4.0)
    update = without_row(mission, 3)
    ack = rig.robot.receive(update)
    assert ack is not None
    assert (ack.outcome, ack.code) == ("rejected", "no_lease")
    assert "pause it first" in ack.text
    rig.do("pause")
    rig.run(2)
    ack = rig.robot.receive(update)
    assert ack is not None
    assert (ack.outcome, ack.sha256) == ("accepted", mission_hash(update))


def test_an_update_behind_the_robot_is_refused_and_nothing_changes() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    update = without_row(mission, 2)
    into_row(rig, 2)
    ack = rig.load(update)
    assert (ack.outcome, ack.code) == ("rejected", "update_too_late")
    assert order(rig).sha256 == mission_hash(mission)
    finish(rig)
    assert set(treated_m(rig)) == {1, 2, 3}


def test_a_stitch_point_too_near_for_a_running_robot_is_too_late() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 2, 10.5)
    ack = rig.load(without_row(mission, 3))
    assert (ack.outcome, ack.code) == ("rejected", "update_too_late")


def test_a_path_that_was_driven_otherwise_is_no_update() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 1)
    update = without_row(mission, 3)
    bent = replace(update.segments[1], points=[(0.1, 0.0), (0.0, 12.0)])
    ack = rig.load(replace(update, segments=[update.segments[0], bent, *update.segments[2:]]))
    assert (ack.outcome, ack.code) == ("rejected", "not_an_update")
    other = replace(update, continues=down.Continues(base_sha256="0" * 64, segments=4))
    assert rig.load(other).code == "mission_active"


def test_the_same_revision_again_is_no_update() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 1)
    assert rig.load(replace(without_row(mission, 3), revision=1)).code == "not_an_update"


def test_a_robot_that_was_moved_after_the_way_was_planned_refuses_it() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 2)
    rig.do("abort")
    rig.run(2)
    update = taken_up(rig, mission)
    carry_to(rig, -10.0, 0.0)
    assert rig.load(update).code == "not_where_planned"
    assert order(rig).status == "aborted"


def test_a_mission_that_was_cut_cannot_be_started_from_its_first_point() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 2)
    rig.do("abort")
    rig.run(2)
    update = taken_up(rig, mission)
    rig.load(update)
    rig.do("abort")
    ack = rig.do("start", mission_id="mission-1", mission_sha256=mission_hash(update))
    assert (ack.outcome, ack.code) == ("rejected", "not_whole")


def test_the_whole_mission_with_a_higher_revision_starts_fresh() -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, 2)
    rig.do("abort")
    assert rig.load(replace(mission, revision=2)).outcome == "accepted"
    assert (order(rig).status, order(rig).row, order(rig).area_done_m2) == ("loaded", 0, 0)


@settings(max_examples=12, deadline=None)
@given(row=st.integers(1, ROWS), into_m=st.floats(1.0, 10.0), x=st.floats(-8, 14), y=st.floats(-8, 20))
@pytest.mark.slow
def test_wherever_it_is_interrupted_and_taken_up_every_row_is_treated_once(
    row: int, into_m: float, x: float, y: float
) -> None:
    rig = Rig()
    mission = small_mission()
    rig.start(mission)
    into_row(rig, row, into_m)
    rig.do("abort")
    rig.run(2)
    carry_to(rig, x, y)
    assert rig.load(taken_up(rig, mission)).outcome == "accepted"
    assert rig.do("resume").outcome == "accepted"
    finish(rig)
    for length in treated_m(rig).values():
        assert length == pytest.approx(12.0, abs=0.35)
    assert set(treated_m(rig)) == {1, 2, 3}
