"""A path with a turn in three pushes: followed backwards with the nose behind, paused, resumed and stopped in it."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from msgspec.structs import replace

from backend_clients.edge import messages_down as down
from backend_clients.edge.codec import mission_hash
from backend_clients.simulator.families import WEEDER
from tests.backend_clients.simulator.rig import Rig, arc, small_mission
from tests.backend_clients.simulator.test_continue import order
from tests.backend_clients.simulator.test_families import until

RADIUS_M, PUSH_M = 5.0, 6.0


def backing_mission() -> down.Mission:
    """Return 8 m east, a quarter to the north, 6 m back to the south, a quarter to the west, 6 m west."""
    corner = (8.0 + RADIUS_M, RADIUS_M - PUSH_M)
    pieces = (
        down.Segment(kind="approach", points=[(0.0, 0.0), (8.0, 0.0)], speed_mps=0.8),
        down.Segment(kind="turn", points=arc(8.0, RADIUS_M, RADIUS_M, -math.pi / 2, 0.0), speed_mps=0.6),
        down.Segment(kind="turn", points=[(8.0 + RADIUS_M, RADIUS_M), corner], speed_mps=0.6, backward=True),
        down.Segment(kind="turn", points=arc(8.0, corner[1], RADIUS_M, 0.0, math.pi / 2), speed_mps=0.6),
        down.Segment(kind="approach", points=[(8.0, 4.0), (2.0, 4.0)], speed_mps=0.8),
    )
    return replace(small_mission(), segments=list(pieces))


def planter(folder: Path | None = None) -> Rig:
    rig = Rig(folder, family="planter", x_m=0.0, y_m=0.0, theta_rad=0.0)
    rig.run(1.0)
    return rig


def is_backing(rig: Rig) -> bool:
    return rig.telemetry.speed_mps < -0.2


def rear_leads(rig: Rig) -> None:
    assert rig.telemetry.theta_rad == pytest.approx(math.pi / 2, abs=0.1), "it looks north while it drives south"
    assert abs(rig.telemetry.cross_track_m or 0.0) < 0.05
    assert not rig.robot.machine.tool_on


def test_it_backs_up_with_its_nose_behind_and_comes_out_where_it_should() -> None:
    rig = planter()
    assert rig.start(backing_mission()).outcome == "accepted"
    until(rig, lambda: is_backing(rig), 120)
    rear_leads(rig)
    until(rig, lambda: order(rig).status == "done", 240)
    base = rig.robot.machine.base
    assert math.dist((base.x_m, base.y_m), (2.0, 4.0)) < 0.2
    assert abs(math.remainder(base.theta_rad - math.pi, 2 * math.pi)) < 0.1


@pytest.mark.slow
def test_paused_while_it_backs_it_goes_on_backwards_also_after_a_restart(tmp_path: Path) -> None:
    rig = planter(tmp_path)
    rig.start(backing_mission())
    until(rig, lambda: is_backing(rig), 120)
    rig.do("pause")
    until(rig, lambda: rig.safety.standstill, 10)
    rig.restart_process()
    rig.run(5.0)
    assert order(rig).status == "paused"
    assert rig.do("resume").outcome == "accepted"
    until(rig, lambda: is_backing(rig), 60)
    rear_leads(rig)
    until(rig, lambda: order(rig).status == "done", 240)


def test_a_stop_while_it_backs_brings_it_to_rest() -> None:
    rig = planter()
    rig.start(backing_mission())
    until(rig, lambda: is_backing(rig), 120)
    rig.stop()
    assert until(rig, lambda: rig.safety.standstill, 3.5) <= 3.0


def test_a_new_rest_taken_while_it_stands_in_such_a_turn_is_driven() -> None:
    rig = planter()
    mission = backing_mission()
    rig.start(mission)
    until(rig, lambda: is_backing(rig), 120)
    rig.do("pause")
    until(rig, lambda: rig.safety.standstill, 10)
    rig.run(1.0)
    now = order(rig)
    assert now.segment == 2
    (x, y0), (_, y1) = mission.segments[2].points
    here = (x, round(y0 - now.segment_s_m, 3))
    head = [*mission.segments[:2], replace(mission.segments[2], points=[(x, y0), here])]
    rest = [replace(mission.segments[2], points=[here, (x, y1)]), *mission.segments[3:]]
    continues = down.Continues(base_sha256=mission_hash(mission), segments=len(head))
    assert rig.load(replace(mission, revision=2, segments=[*head, *rest], continues=continues)).outcome == "accepted"
    assert rig.do("resume").outcome == "accepted"
    until(rig, lambda: is_backing(rig), 60)
    rear_leads(rig)
    until(rig, lambda: order(rig).status == "done", 240)


def test_a_machine_that_follows_no_path_backwards_refuses_the_mission() -> None:
    assert WEEDER.motion.path_reverse_mps is None
    rig = Rig()
    rig.run(1.0)
    ack = rig.load(backing_mission())
    assert (ack.outcome, ack.code) == ("rejected", "bad_mission")
    assert "backwards" in ack.text
