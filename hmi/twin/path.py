"""The plan on the ground: parcels, rows done, the one being worked, those to come."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import viser
from numpy.typing import NDArray

from backend_clients.edge.messages_up import OrderState
from hmi.twin.farm import Plan, Swath
from hmi.twin.ground_frame import SiteFrame

DONE, NOW, NEXT, EDGE = (70, 82, 88), (20, 30, 36), (150, 156, 158), (96, 104, 108)
LIFT_M = 0.02
BEGUN = ("running", "paused", "aborted", "failed")
Lines = NDArray[np.float32]


class PathLines:
    """Draws the path of the mission a robot has; nothing of a plan for another mission is called done."""

    def __init__(self, scene: viser.SceneApi, path: str, parcel: str) -> None:
        self._scene, self._path, self._parcel = scene, path, parcel
        self._plan = Plan()
        self._lines: list[tuple[Swath, Lines]] = []
        self._shown: tuple[int, str] | None = None

    def set_plan(self, plan: Plan, frame: SiteFrame) -> None:
        """Take another plan."""
        if plan == self._plan:
            return
        self._plan, self._shown = plan, None
        self._lines = [(swath, _line(swath.points, frame)) for swath in plan.path if len(swath.points) > 1]
        self._draw(
            "parcels", self._parcel, [_line([*ring, ring[0]], frame) for ring in plan.parcels if ring], EDGE, 1.5
        )

    def show(self, order: OrderState | None) -> None:
        """Draw progress; only when another piece of the path is being worked."""
        at = self._at(order)
        key = (at, self._plan.mission_id)
        if key == self._shown:
            return
        self._shown = key
        lines = [line for _, line in self._lines]
        self._draw("done", self._path, lines[: max(at, 0)], DONE, 4.0)
        self._draw("now", self._path, lines[at : at + 1] if at >= 0 else [], NOW, 5.0)
        self._draw("next", self._path, lines[at + 1 :], NEXT, 1.5)

    def _at(self, order: OrderState | None) -> int:
        """Return the piece that is worked, -1 before the first and one past the last when all is done.

        As the map draws it: static/js/map/mission.js.
        """
        if order is None or order.mission_id != self._plan.mission_id:
            return -1
        if order.status == "done":
            return len(self._lines)
        return order.segment if order.status in BEGUN else -1

    def _draw(self, name: str, below: str, lines: Iterable[Lines], colour: tuple[int, int, int], width: float) -> None:
        pairs = [np.stack([line[:-1], line[1:]], axis=1) for line in lines]
        if not pairs:
            self._scene.remove_by_name(f"{below}/{name}")
            return
        self._scene.add_line_segments(
            f"{below}/{name}", np.concatenate(pairs), colors=colour, thickness=width, thickness_units="screen"
        )


def _line(points: Iterable[tuple[float, float]], frame: SiteFrame) -> Lines:
    return np.asarray([(*frame.local(lat, lon), LIFT_M) for lon, lat in points], np.float32)
