"""The path of a mission in the scene: what is done, worked and to come, as the map draws it."""

from __future__ import annotations

from collections.abc import AsyncIterator

import pytest
import viser

from backend_clients.edge.messages_up import OrderState
from hmi.twin.farm import Plan, Swath
from hmi.twin.ground_frame import SiteFrame
from hmi.twin.guarded_viser import guarded_viser
from hmi.twin.path import PathLines

PLAN = Plan("m-1", [Swath([(5.0, 52.0 + i * 1e-5), (5.001, 52.0 + i * 1e-5)], i + 1) for i in range(3)])


@pytest.fixture
async def scene() -> AsyncIterator[viser.SceneApi]:
    """A scene nobody looks at."""
    server = guarded_viser(lambda _headers: True)
    yield server.scene
    server.stop()


@pytest.mark.parametrize(
    ("status", "segment", "pieces"),
    [
        ("loaded", 0, (0, 0, 3)),
        ("running", 1, (1, 1, 1)),
        ("paused", 0, (0, 1, 2)),
        ("aborted", 2, (2, 1, 0)),
        ("failed", 1, (1, 1, 1)),
        ("done", 2, (3, 0, 0)),
        ("none", 0, (0, 0, 3)),
    ],
)
async def test_done_worked_and_to_come_go_by_the_missions_status(
    scene: viser.SceneApi, status: str, segment: int, pieces: tuple[int, int, int]
) -> None:
    lines = PathLines(scene, "/path", "/parcel")
    lines.set_plan(PLAN, SiteFrame())
    order = OrderState(
        mission_id="m-1", revision=1, sha256="a" * 64, row=1, rows=3, distance_m=0, status=status, segment=segment
    )  # type: ignore[arg-type]
    lines.show(order)

    def drawn(name: str) -> int:
        handle = scene.get_handle_by_name(f"/path/{name}")
        return 0 if handle is None else len(handle.points)  # type: ignore[attr-defined]

    assert (drawn("done"), drawn("now"), drawn("next")) == pieces
