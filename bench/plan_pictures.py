"""``python -m bench.plan_pictures``: plans of known fields as pictures, into ``docs/plans``.

A change of the planner that changes a plan changes its picture; whoever makes it looks at both.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
from PIL import Image, ImageDraw, ImageFont
from shapely.geometry import Polygon

from hmi.domain.mission_plan import Pattern, Rows
from hmi.planning.coverage import plan_coverage
from hmi.planning.drawing import drawing
from hmi.planning.job import Job
from hmi.planning.machine import RobotProfile
from hmi.planning.plan import Plan
from hmi.planning.projection import LocalFrame
from hmi.planning.recorded import CropRow
from hmi.planning.treatment import DoseMap
from tests.e2e.installation import ROOT
from tests.hmi.planning.grounds import given_field, square

OUT = ROOT / "docs" / "plans"
PANEL, MARGIN, TEXT, FINER = 520, 24, 62, 2
COLOURS = 64
FRAME = LocalFrame(52.0, 5.5)  # where on earth does not show
NAMES = {
    Pattern.SHORTEST: "Shortest",
    Pattern.ROW_BY_ROW: "Row by row",
    Pattern.SKIP_ROWS: "Skip rows",
    Pattern.SPIRAL: "Spiral",
}
INK, PATH, TURN, IDLE, GROUND, EDGE, HOLE, TWICE, MISSED, GUIDE, BACK = (
    "#12181b", "#23414f", "#8a3f00", "#9aa5aa", "#e9eae3", "#737970", "#c9ccc4", "#9db4c0", "#f2c500", "#8fc3e8",
    "#1672c4",
)  # fmt: skip


def main() -> int:
    """Write the pictures; return an exit code."""
    OUT.mkdir(parents=True, exist_ok=True)
    for name, jobs in _sheets():
        panels = [_panel(title, job) for title, job in jobs]
        _side_by_side(panels).save(OUT / f"{name}.png", optimize=True)
        print(f"{name}.png", flush=True)
    return 0


def _sheets() -> Iterator[tuple[str, list[tuple[str, Job]]]]:
    machine = RobotProfile(turning_radius_m=1.5)
    holes = square(110).difference(shapely.union_all([shapely.box(28, 60, 38, 70), shapely.Point(74, 38).buffer(7)]))
    assert isinstance(holes, Polygon)
    for name, field, width in (("nl-parcel", given_field("nl-parcel"), 6.0), ("holes", holes, 3.0)):
        yield name, [(NAMES[p], Job(field, width, machine, pattern=p)) for p in Pattern]
    section = Job(square(20), 0.5, RobotProfile())  # a section of the experimental site: maize, rows half a metre apart
    yield "site-w", [(NAMES[p], replace(section, pattern=p)) for p in Pattern]
    wet, weedy = shapely.box(-5, -5, 45, 40), shapely.Point(85, 80).buffer(22)
    dosed = Job(holes, 3.0, machine, doses=DoseMap(((wet, 0.0), (weedy, 2.0)), 1.0, 0.3, 0.1))
    only = replace(dosed, doses=DoseMap(((weedy, 1.0),), 0.0, 0.3, 0.1))
    planter = RobotProfile(6.4, 2.6, 4.0, turning_radius_m=5.0, can_pivot=False, yaw_rate_radps=0.35)
    wide = Job(shapely.Polygon([(0, 0), (95, 14), (100, 92), (-8, 84)]), 4.0, planter, angle_rad=np.pi / 2)
    backing = replace(wide, machine=replace(planter, reverse_mps=0.6))
    yield "backing", [("Driving on in each turn", wide), ("Backing up in turns (blue)", backing)]
    yield "curved", list(_curved(holes, machine))
    yield "treatment", [("A wet corner off, a weedy patch twice", dosed), ("Only the patch", only)]


def _curved(field: Polygon, machine: RobotProfile) -> Iterator[tuple[str, Job]]:
    def line(x0: float, x1: float, y: float) -> Any:
        x = np.linspace(x0, x1, 60)
        points = np.column_stack([x, y + 11 * np.sin(x / 35)])
        return points[(points[:, 1] > 4) & (points[:, 1] < 106)]

    guide = CropRow("Guide", line(0, 110, 45))
    yield "Along a guide line", Job(field, 3.0, machine, rows=Rows.GUIDE_LINE, lines=(guide,))
    rows = [CropRow(f"row {k}", line(5, 105, -6 + 3 * k)) for k in range(1, 34) if k not in (17, 18)]
    yield "Along recorded rows, two missing", Job(field, 3.0, machine, rows=Rows.RECORDED_ROWS, lines=tuple(rows))


def _panel(title: str, job: Job) -> Image.Image:
    plan = plan_coverage(job)
    drawn = drawing(job, plan, FRAME)
    left, low, right, high = job.parcel.bounds
    scale = (PANEL - 2 * MARGIN) / max(right - left, high - low) * FINER
    picture = Image.new("RGB", (PANEL * FINER, (PANEL + TEXT) * FINER), "white")
    pen = ImageDraw.Draw(picture)

    def at(x: float, y: float) -> tuple[float, float]:
        return (x - left) * scale + MARGIN * FINER, (high - y) * scale + (MARGIN + TEXT) * FINER

    outer, *holes = drawn["places"]["parcel"]
    pen.polygon([at(*point) for point in outer], fill=GROUND)
    for name, colour in (("twice", TWICE), ("missed", MISSED)):
        for rings in drawn["ground"][name]:
            pen.polygon([at(*point) for point in rings[0]], fill=colour)
            for hole in rings[1:]:
                pen.polygon([at(*point) for point in hole], fill=GROUND)
    for ring in holes:
        pen.polygon([at(*point) for point in ring], fill=HOLE)
    for ring in (outer, *holes):
        pen.line([at(*point) for point in ring], fill=EDGE, width=2 * FINER)
    for line in drawn["places"]["lines"]:
        pen.line([at(*point) for point in line], fill=GUIDE, width=3 * FINER, joint="curve")
    for leg in drawn["legs"]:
        points = list(zip(leg["xy"][::2], leg["xy"][1::2], strict=True))
        colour = (PATH if leg["on"] else IDLE) if leg["kind"] in ("row", "headland") else TURN
        colour = BACK if leg.get("back") else colour
        width = round((1.4 if leg["on"] else 1) * max(1.0, leg["dose"])) * FINER
        pen.line([at(*point) for point in points], fill=colour, width=width, joint="curve")
    _ends(pen, drawn, at)
    _words(pen, title, plan)
    return picture.resize((PANEL, PANEL + TEXT), Image.Resampling.LANCZOS)


def _ends(pen: ImageDraw.ImageDraw, drawn: dict[str, Any], at: Any) -> None:
    first, last = drawn["legs"][0]["xy"][:2], drawn["legs"][-1]["xy"][-2:]
    radius = 7 * FINER
    (x, y), (u, v) = at(*first), at(*last)
    pen.ellipse((x - radius, y - radius, x + radius, y + radius), fill="white", outline=INK, width=3 * FINER)
    pen.rectangle((u - radius, v - radius, u + radius, v + radius), fill=INK, outline="white", width=FINER)


def _words(pen: ImageDraw.ImageDraw, title: str, plan: Plan) -> None:
    figures = plan.figures
    hours, minutes = divmod(round(figures.duration_s / 60), 60)
    wanted = 100 * (1 - figures.missed_m2 / figures.wanted_m2)
    line = (
        f"{figures.rows} rows   {figures.length_m / 1000:.2f} km   {hours}:{minutes:02d} h   {figures.turns} turns, "
        f"{figures.pivots} on the spot   {wanted:.1f} % of what is wanted"
    )
    pen.text((MARGIN * FINER, 12 * FINER), title, fill=INK, font=ImageFont.load_default(20 * FINER))
    pen.text((MARGIN * FINER, 40 * FINER), line, fill=INK, font=ImageFont.load_default(12.5 * FINER))


def _side_by_side(panels: list[Image.Image]) -> Image.Image:
    width, height = panels[0].size
    rows = (len(panels) + 1) // 2
    whole = Image.new("RGB", (2 * width, rows * height), "white")
    for number, panel in enumerate(panels):
        whole.paste(panel, ((number % 2) * width, (number // 2) * height))
    return whole.quantize(COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)


if __name__ == "__main__":
    sys.exit(main())
