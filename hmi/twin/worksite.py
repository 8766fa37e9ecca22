"""Where a robot works: the surface of this stop, obstacles, and every place by what became of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import viser

from backend_clients.edge.machine import Obstacle, Target, Worksite
from hmi.twin.farm import Treated
from hmi.twin.marks import CROSS, RING, TREE, Mark, draw_marks
from hmi.twin.model import Cylinder
from hmi.twin.solids import triangles_of

FAILED = frozenset(CROSS)
ENDED = {"done": TREE, **CROSS}
STUMP = (112, 92, 72)
EDGE = (96, 104, 108)
NAME_ASIDE_M, NAME_UP_M = 0.9, 0.7
Point = tuple[float, float]


class WorkSurface:
    """Draws one robot's worksite. What was done at earlier stops stays, what was planned there goes.

    Args:
        trees: frame of all places; ``now`` below it is that of the places that are planned or worked at.
        obstacles: frame of stumps, stones and the edge of the surface.
    """

    def __init__(self, scene: viser.SceneApi, trees: str, now: str, obstacles: str) -> None:
        self._scene, self._trees, self._now, self._obstacles = scene, trees, now, obstacles
        scene.add_frame(now, show_axes=False)
        self._ended: dict[str, tuple[float, float, str]] = {}
        self._ended_ms: dict[str, int] = {}
        self._is_heard = False
        self.ends = 0  # how often a place ended, or was told to have: it changes with what is over
        self._before: Sequence[Treated] = ()
        self._drawn: tuple[object, ...] = ()
        self._batches: dict[str, list[Point]] = {}
        self._site: Worksite | None = None
        self._shift: Point = (0.0, 0.0)

    @property
    def done(self) -> int:
        """How many places are done."""
        return sum(1 for _, _, status in self._ended.values() if status == "done")

    @property
    def failed(self) -> int:
        """How many places failed."""
        return sum(1 for _, _, status in self._ended.values() if status in FAILED)

    @property
    def site(self) -> Worksite | None:
        """The worksite that is drawn."""
        return self._site

    def ended(self) -> Iterable[tuple[str, float, float, str]]:
        """Yield id, metres east and north in the robot's plane, and outcome of every place that is over."""
        return ((name, *rest) for name, rest in self._ended.items())

    def ended_after(self, at_ms: int) -> frozenset[str]:
        """Return the places that were over only after a moment, UTC; those of which nobody knows when are none."""
        return frozenset(name for name, ended_ms in self._ended_ms.items() if ended_ms > at_ms)

    def without(self, undone: frozenset[str]) -> dict[str, tuple[Mark, list[Point]]]:
        """Return, by frame, the marks of each outcome that some of ``undone`` had, without those."""
        outcomes = {self._ended[name][2] for name in undone if name in self._ended}
        return {f"{self._trees}/{outcome}": (ENDED[outcome], self._places(outcome, undone)) for outcome in outcomes}

    def set_before(self, treated: Sequence[Treated]) -> None:
        """Take what was done before anybody listened."""
        self._before = treated
        for one in treated:
            self._ended.setdefault(one.id, (one.x_m, one.y_m, one.outcome))
            self._ended_ms[one.id] = self._ended_ms.get(one.id) or one.at_ms
        self.ends += 1
        self._drawn = ()

    def show(self, site: Worksite | None, shift: Point, now_ms: int) -> None:
        """Draw the worksite if it changed. ``now_ms`` is the time, UTC."""
        if site is not None and site is not self._site:
            self._note_ended(site, now_ms)
        key = (None if site is None else (site.boot, site.seq), len(self._ended), shift)
        if key == self._drawn:
            return
        self._drawn, self._site, self._shift = key, site, shift
        self._draw_places([] if site is None else site.targets, shift)
        self._draw_obstacles([] if site is None else site.obstacles, shift)
        self._draw_area([] if site is None else site.area, shift)

    def _note_ended(self, site: Worksite, now_ms: int) -> None:
        """Note what is over; of what was over in the first one that is heard nobody knows since when."""
        for target in site.targets:
            if target.status != "done" and target.status not in FAILED:
                continue
            before = self._ended.get(target.id)
            self._ended[target.id] = (target.x_m, target.y_m, target.status)
            if before is None or before[2] != target.status:
                self.ends += 1
                self._ended_ms.setdefault(target.id, 0)
                if self._is_heard:
                    self._ended_ms[target.id] = now_ms
        self._is_heard = True

    def _draw_places(self, targets: Sequence[Target], shift: Point) -> None:
        for outcome, mark in ENDED.items():
            self._batch(f"{self._trees}/{outcome}", mark, self._places(outcome))
        for status, mark in RING.items():
            here = [(t.x_m + shift[0], t.y_m + shift[1]) for t in targets if t.status == status]
            self._batch(f"{self._now}/{status}", mark, here)
        self._name([t for t in targets if t.status == "current"], shift)

    def _places(self, outcome: str, but: frozenset[str] = frozenset()) -> list[Point]:
        """Where places ended so, in the site's plane."""
        east, north = self._shift
        return [
            (x + east, y + north) for name, (x, y, ended) in self._ended.items() if ended == outcome and name not in but
        ]

    def _name(self, current: Sequence[Target], shift: Point) -> None:
        """Name the place that is worked at, on a line above it, so that the tool does not hide it."""
        frame = f"{self._now}/named"
        if not current:
            self._scene.remove_by_name(frame)
            return
        x, y = current[0].x_m + shift[0], current[0].y_m + shift[1]
        number = current[0].id.rsplit("-", 1)[-1]
        text = f"Tree {int(number)}" if number.isdecimal() else current[0].id
        line = np.asarray([[(0.0, 0.0, 0.04), (NAME_ASIDE_M, 0.0, NAME_UP_M)]], np.float32)
        self._scene.add_frame(frame, show_axes=False, position=(x, y, 0.0))
        self._scene.add_line_segments(f"{frame}/line", line, colors=EDGE, thickness=2.0, thickness_units="screen")
        self._scene.add_label(f"{frame}/text", text, position=(NAME_ASIDE_M, 0.0, NAME_UP_M), anchor="bottom-center")

    def _batch(self, frame: str, mark: Mark, places: list[Point]) -> None:
        """Draw marks in the site's plane; thousands that did not change are not sent again."""
        if places == self._batches.get(frame, []):
            return
        self._batches[frame] = places
        if places:
            draw_marks(self._scene, frame, mark, places)
        else:
            self._scene.remove_by_name(frame)

    def _draw_obstacles(self, obstacles: Sequence[Obstacle], shift: Point) -> None:
        frame = f"{self._obstacles}/cylinders"
        if not obstacles:
            self._scene.remove_by_name(frame)
            return
        corners = triangles_of(Cylinder(1.0, 1.0)) + np.asarray((0, 0, 0.5), np.float32)
        faces = np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)
        positions = np.asarray([(one.x_m + shift[0], one.y_m + shift[1], 0.0) for one in obstacles], np.float32)
        scales = np.asarray([(one.radius_m, one.radius_m, max(one.height_m, 0.05)) for one in obstacles], np.float32)
        turns = np.tile(np.asarray([1, 0, 0, 0], np.float32), (len(obstacles), 1))
        self._scene.add_batched_meshes_simple(
            frame, corners, faces, turns, positions, batched_scales=scales, batched_colors=STUMP, flat_shading=True
        )

    def _draw_area(self, area: Sequence[Point], shift: Point) -> None:
        frame = f"{self._obstacles}/surface"
        if len(area) < 3:
            self._scene.remove_by_name(frame)
            return
        ring = np.asarray([(x + shift[0], y + shift[1], 0.015) for x, y in [*area, area[0]]], np.float32)
        pairs = np.stack([ring[:-1], ring[1:]], axis=1)
        self._scene.add_line_segments(frame, pairs, colors=EDGE, thickness=2.0, thickness_units="screen")
