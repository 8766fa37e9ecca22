"""Rows along a curve, as cameras see them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from backend_clients.edge.messages_down import Segment
from backend_clients.simulator.cameras.bent_rows import BentRows, is_bent, leading_row
from backend_clients.simulator.cameras.crops import LEAVES_SHARE, crop_of, outcome_of, plants_near, weeds_near
from backend_clients.simulator.cameras.mounts import MOUNTS
from backend_clients.simulator.cameras.row_frame import from_field, to_field
from backend_clients.simulator.cameras.scene import Ground, Rows, Scene
from backend_clients.simulator.route import Route
from tests.backend_clients.simulator.cameras.field import drawn, look

RADIUS_M = 30.0
FIELD = [(-90.0, -90.0), (90.0, -90.0), (90.0, 90.0), (-90.0, 90.0)]


def on_arc(metres: float, left: float = 0.0) -> tuple[float, float]:
    """Return a place on a circle that begins northwards at the origin and bends to the left."""
    angle = metres / RADIUS_M
    return -RADIUS_M + (RADIUS_M - left) * math.cos(angle), (RADIUS_M - left) * math.sin(angle)


def arc(left: float = 0.0, row: int = 1, metres: float = 45.0) -> Segment:
    points = [on_arc(s, left) for s in np.arange(0.0, metres, 0.5)]
    return Segment(kind="row", points=points if row % 2 else points[::-1], speed_mps=0.4, row=row, tool_on=True)


def rows_of(*segments: Segment) -> BentRows:
    route = Route(segments)
    leg = leading_row(route)
    assert leg is not None
    assert is_bent(route, leg)
    return BentRows(route, leg, "Sugar beet", 0.5)


@pytest.mark.parametrize("left", [-6.0, 0.0, 6.0])
@pytest.mark.parametrize("along", [5.0, 20.0, 38.0])
def test_a_place_is_as_far_along_and_across_the_rows_as_the_circle_says(along: float, left: float) -> None:
    near = rows_of(arc()).near(on_arc(along, left))
    [(s, d)] = to_field(near, np.array([on_arc(along, left)]))
    assert s == pytest.approx(along, abs=0.05)
    assert d == pytest.approx(left, abs=0.02)
    assert math.remainder(near.bearing_rad - (math.pi / 2 + along / RADIUS_M), 2 * math.pi) == pytest.approx(
        0, abs=0.02
    )


@pytest.mark.parametrize("left", [-3.0, 0.0, 3.0])
def test_a_plant_stays_where_it_stands_while_the_machine_comes_nearer(left: float) -> None:
    rows, plant = rows_of(arc()), np.array([on_arc(24.0, left + 0.5)])
    places = [to_field(rows.near(on_arc(s, left)), plant)[0] for s in np.arange(19.0, 24.0, 0.5)]
    assert np.ptp(np.array(places), axis=0) == pytest.approx([0, 0], abs=0.12)
    assert places[-1] == pytest.approx([24.0, left + 0.5], abs=0.05)


def test_there_and_back_is_the_same_place() -> None:
    near = rows_of(arc()).near(on_arc(20.0))
    points = np.array([on_arc(s, left) for s in (14.0, 20.0, 27.0) for left in (-4.0, 0.0, 4.0)])
    assert from_field(near, to_field(near, points)) == pytest.approx(points, abs=0.02)


def test_straight_rows_are_none_that_bend_and_the_longest_row_leads() -> None:
    line = Segment(kind="row", points=[(0.0, 0.0), (0.0, 20.0), (0.04, 40.0)], speed_mps=0.4, row=1, tool_on=True)
    short = Segment(kind="row", points=[(0.04, 40.0), (1.0, 40.0)], speed_mps=0.4, row=2, tool_on=True)
    route = Route([line, short])
    leg = leading_row(route)
    assert leg is not None
    assert leg.row == 1
    assert not is_bent(route, leg)


def test_plants_of_bent_rows_are_drawn_along_the_curve() -> None:
    here = on_arc(12.0)
    near = rows_of(arc()).near(here)
    scene = Scene("field", 52.0, 5.0, [Ground("field", FIELD, Rows("Sugar beet", 0.5, 0.3, (0.0, 0.0)), is_bent=True)])
    theta = math.pi / 2 + 12.0 / RADIUS_M
    wanted = look(x_m=here[0], y_m=here[1], theta_rad=theta, rows=near)
    pixels, boxes = drawn(wanted, scene)
    assert any(box.kind == "weed" for box in boxes)
    eye, high = MOUNTS["weeder", "front"].eye(wanted, 640, 480), crop_of("Sugar beet").high_m
    lines = {0.0: [], 0.25: []}
    for left, green in lines.items():
        for s in np.arange(14.5, 17.0, 0.1):
            u, v, _ = eye.project(np.array([(*on_arc(s, left), high * LEAVES_SHARE)]))
            part = pixels[round(v[0]) - 2 : round(v[0]) + 3, round(u[0]) - 2 : round(u[0]) + 3].astype(float)
            green.append(float((part[:, :, 1] - part[:, :, 0]).mean()))
    assert np.median(lines[0.0]) > np.median(lines[0.25]) + 8


def test_the_tool_hits_weeds_along_the_curve_and_not_along_its_chord() -> None:
    rows = rows_of(arc())
    leg = rows.leg
    treated = rows.worked(leg, leg.end_m, on_arc(20.0), 16.0)
    near = rows.near(on_arc(20.0))
    weeds = weeds_near(near, *on_arc(20.0), 6.0)
    off = np.abs(to_field(near, weeds[:, :2])[:, 1])
    outcome = outcome_of(weeds, treated)
    assert set(outcome[off < 0.6]) <= {0, 1}
    assert (outcome[off > 1.0] == -1).all()
    assert rows.worked(leg, leg.end_m, (500.0, 0.0), 16.0) == []


def test_only_what_was_driven_already_is_worked() -> None:
    rows = rows_of(arc())
    treated = rows.worked(rows.leg, 10.0, on_arc(10.0), 16.0)
    assert math.dist(treated[-1][2:], on_arc(10.0)) < 0.05
    assert plants_near(rows.near(on_arc(10.0)), *on_arc(12.0), 0.5).shape[0] > 4
