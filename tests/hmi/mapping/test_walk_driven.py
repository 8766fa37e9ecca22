"""An edge recorded from a simulated robot while it drives around it: as exact as its receiver and its steering."""

from __future__ import annotations

import pytest
import shapely

from backend_clients.edge import messages_down as down
from backend_clients.simulator.enu import EnuFrame
from hmi.mapping.walk import WalkPoint, outline
from tests.backend_clients.simulator.rig import LAT, LON, Rig, small_mission
from tests.backend_clients.simulator.test_continue import order

CORNERS = [(0.0, 0.0), (24.0, 0.0), (27.0, 15.0), (3.0, 18.0), (0.0, 0.0)]
HEARD_S = 0.5  # a page takes a position each time it paints


def heard_on_the_way() -> list[WalkPoint]:
    """Return what a page hears while the robot drives around."""
    rig = Rig(y_m=0.0, theta_rad=0.0)
    rig.run(1.0)
    rig.start(small_mission(segments=[down.Segment(kind="approach", points=CORNERS, speed_mps=1.2)]))
    points: list[WalkPoint] = []
    while order(rig).status != "done":
        rig.run(HEARD_S)
        told = rig.telemetry
        points.append(WalkPoint(told.lon_deg, told.lat_deg, told.gnss.accuracy_m, told.mono_ms / 1000))
        assert len(points) < 1000
    return points


def test_a_robot_that_drives_around_a_field_records_its_edge() -> None:
    found = outline(heard_on_the_way(), is_closed=True, tolerance_m=0.1)
    frame, truth = EnuFrame(LAT, LON), shapely.Polygon(CORNERS)
    walked = shapely.Polygon([frame.to_enu(lat, lon) for lon, lat in found.coordinates])
    assert walked.hausdorff_distance(truth) < 0.05
    assert walked.area == pytest.approx(truth.area, rel=0.005)
    assert len(found.coordinates) == 5, "straight edges have no corners"
    assert found.accuracy_m < 0.03
    assert found.tolerance_m == 0.1
