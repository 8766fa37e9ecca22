"""One staging area: its obstacles, and the planting points found between them.

Frames: the area lies in the robot's ENU frame; the crane reaches in the machine's frame.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from backend_clients.edge.machine import Obstacle, Target
from backend_clients.simulator.crane import OutOfReach, pose_for
from backend_clients.simulator.enu import Point
from backend_clients.simulator.kinematics import Base

CLEAR_M = 0.2  # free radius around a plant
TREES_PER_M2 = 0.25  # 2,500 a hectare
AREA_M = 4.0  # of the staging area along the row, and at most across it
CARRY_M = 1.6  # of the tip on the way to a point
HOVER_M = 0.6  # of the tip above the ground before it is lowered
MARGIN_M = 0.5  # from the machine's outline
SAME_M = 0.5
SEARCH_M = 0.1  # between two spots that are tried
_KINDS = (("stump", (0.12, 0.32), (0.2, 0.5)), ("stone", (0.08, 0.28), (0.08, 0.3)))


@dataclass(frozen=True, slots=True)
class Stretch:
    """A piece of a row that is planted from one stop of the machine; metres along the path.

    ``plants_m``: where its plants stand in one line, ``spacing_m`` apart, if the mission says so.
    """

    row: int
    from_m: float
    to_m: float
    stop_m: float
    plants_m: tuple[float, ...] = ()
    spacing_m: float | None = None


@dataclass(slots=True)
class Site:
    """An area with its obstacles and points; ``outcomes`` are kept until the next stop."""

    stop: int
    row: int
    area: list[Point]
    obstacles: list[Obstacle] = field(default_factory=list)
    targets: list[Target] = field(default_factory=list)
    revision: int = 0

    @property
    def current(self) -> Target | None:
        """The point that is worked at."""
        return next((one for one in self.targets if one.status == "current"), None)

    @property
    def is_left(self) -> bool:
        """Whether a point is still to be worked at."""
        return any(one.status in ("planned", "current") for one in self.targets)

    def take_next(self) -> Target | None:
        """Make the next planned point the current one."""
        found = self.current or next((one for one in self.targets if one.status == "planned"), None)
        if found is not None and found.status == "planned":
            self.mark(found.id, "current")
            return self.current
        return found

    def mark(self, target: str, status: str, text: str = "") -> None:
        """Note what became of a point."""
        self.targets = [replace_target(one, status, text) if one.id == target else one for one in self.targets]
        self.revision += 1

    def is_around(self, at: Point) -> bool:
        """Say whether this is the area that begins at ``at``."""
        (ax, ay), _, _, (bx, by) = self.area
        return math.dist(at, ((ax + bx) / 2, (ay + by) / 2)) < SAME_M

    @property
    def planted(self) -> int:
        """How many trees stand here."""
        return sum(one.status == "done" for one in self.targets)


def replace_target(target: Target, status: str, text: str) -> Target:
    """Return a point with another outcome."""
    return Target(id=target.id, x_m=target.x_m, y_m=target.y_m, status=status, text=text)  # type: ignore[arg-type]


def area_of(ends: tuple[Point, Point], width_m: float) -> list[Point]:
    """Return the four corners of the area along a piece of row, ``width_m`` wide."""
    (ax, ay), (bx, by) = ends
    length_m = math.dist(*ends) or 1.0
    sx, sy = -(by - ay) / length_m * width_m / 2, (bx - ax) / length_m * width_m / 2
    return [(ax + sx, ay + sy), (bx + sx, by + sy), (bx - sx, by - sy), (ax - sx, ay - sy)]


def map_site(
    site: Site,
    base: Base,
    width_m: float,
    seed: str,
    *,
    first_tree: int,
    most: int | None = None,
    line: Stretch | None = None,
) -> None:
    """Find obstacles, then the points that the crane reaches and that are clear of them.

    They are up to 2,500 a hectare, or as far apart as the mission says.

    Args:
        base: how the machine stands.
        seed: makes the obstacles repeatable.
        first_tree: number of the first point.
        most: no more points than this.
        line: the piece of row that is planted here.
    """
    rng = random.Random(seed)  # noqa: S311
    site.obstacles = _obstacles(site, rng)
    is_in_line = line is not None and line.spacing_m is not None
    cells = _cells_in_line(site.area, line) if line is not None and is_in_line else _cells(site.area, width_m)
    spots = [spot for cell in cells if (spot := _spot(cell, site, base)) is not None]
    spots.sort(key=lambda at: to_machine(base, at)[1])
    site.targets = [
        Target(id=f"tree-{first_tree + n}", x_m=round(x, 3), y_m=round(y, 3), status="planned")
        for n, (x, y) in enumerate(spots[:most])
    ]
    site.revision += 1


def to_machine(base: Base, at: Point) -> Point:
    """Return a place of the ENU frame in the machine's."""
    dx, dy = at[0] - base.x_m, at[1] - base.y_m
    cos, sin = math.cos(base.theta_rad), math.sin(base.theta_rad)
    return dx * cos + dy * sin, -dx * sin + dy * cos


def to_enu(base: Base, at: Point) -> Point:
    """Return a place of the machine's frame in ENU."""
    cos, sin = math.cos(base.theta_rad), math.sin(base.theta_rad)
    return base.x_m + at[0] * cos - at[1] * sin, base.y_m + at[0] * sin + at[1] * cos


def is_reachable(base: Base, at: Point, front_m: float = 4.0, rear_m: float = 2.4, half_m: float = 1.3) -> bool:
    """Say whether the crane can plant there: within its joints, and not under the machine."""
    x, y = to_machine(base, at)
    if -rear_m - MARGIN_M < x < front_m + MARGIN_M and abs(y) < half_m + MARGIN_M:
        return False
    try:
        for z in (CARRY_M, HOVER_M, 0.0):
            pose_for((x, y, z))
    except OutOfReach:
        return False
    return True


def _obstacles(site: Site, rng: random.Random) -> list[Obstacle]:
    found = []
    for number in range(rng.choice((0, 1, 2, 2, 3, 4))):
        kind, radius, height = rng.choice(_KINDS)
        x, y = _inside(site.area, rng.random(), rng.random())
        found.append(
            Obstacle(
                id=f"{kind}-{site.stop}-{number + 1}",
                kind=kind,
                x_m=round(x, 3),
                y_m=round(y, 3),
                radius_m=round(rng.uniform(*radius), 2),
                height_m=round(rng.uniform(*height), 2),
            )
        )
    return found


def _inside(area: Sequence[Point], along: float, across: float) -> Point:
    (ax, ay), (bx, by), _, (dx, dy) = area
    return ax + along * (bx - ax) + across * (dx - ax), ay + along * (by - ay) + across * (dy - ay)


def _cells(area: Sequence[Point], width_m: float) -> Iterator[tuple[Point, Point, Point]]:
    """Yield for each tree that may stand in the area: the middle of its part, and the halves along and across."""
    length_m = math.dist(area[0], area[1])
    many = max(round(length_m * width_m * TREES_PER_M2), 1)
    across = max(round(math.sqrt(many * width_m / max(length_m, 0.1))), 1)
    along = max(round(many / across), 1)
    (ax, ay), (bx, by), _, (dx, dy) = area
    half_u = ((bx - ax) / along / 2, (by - ay) / along / 2)
    half_v = ((dx - ax) / across / 2, (dy - ay) / across / 2)
    for i in range(along):
        for j in range(across):
            yield _inside(area, (i + 0.5) / along, (j + 0.5) / across), half_u, half_v


def _cells_in_line(area: Sequence[Point], line: Stretch) -> Iterator[tuple[Point, Point, Point]]:
    """Yield as ``_cells`` for the plants of a line along the middle of the area."""
    length_m, share = line.to_m - line.from_m, (line.spacing_m or 0.0) / 2 / (line.to_m - line.from_m)
    (ax, ay), (bx, by), _, (dx, dy) = area
    for plant_m in line.plants_m:
        at = _inside(area, (plant_m - line.from_m) / length_m, 0.5)
        yield at, ((bx - ax) * share, (by - ay) * share), ((dx - ax) / 2, (dy - ay) / 2)


def _spot(cell: tuple[Point, Point, Point], site: Site, base: Base) -> Point | None:
    """Return the free spot nearest to the middle of a cell, ``None`` if there is none."""
    (x, y), (ux, uy), (vx, vy) = cell
    steps_u, steps_v = (int(max(math.hypot(*half) - 0.4, 0.0) / SEARCH_M) for half in ((ux, uy), (vx, vy)))
    tries = [(i, j) for i in range(-steps_u, steps_u + 1) for j in range(-steps_v, steps_v + 1)]
    tries.sort(key=lambda at: at[0] * at[0] + at[1] * at[1])
    for i, j in tries:
        a, b = i * SEARCH_M / math.hypot(ux, uy), j * SEARCH_M / math.hypot(vx, vy)
        at = (x + a * ux + b * vx, y + a * uy + b * vy)
        if is_clear(at, site.obstacles) and is_reachable(base, at):
            return at
    return None


def is_clear(at: Point, obstacles: Sequence[Obstacle]) -> bool:
    """Say whether the ground around a plant would be free."""
    return all(math.dist(at, (one.x_m, one.y_m)) >= one.radius_m + CLEAR_M for one in obstacles)
