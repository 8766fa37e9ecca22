"""Draws weeds where they stand: green until the laser was there, burnt where it hit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PIL import Image

from backend_clients.simulator.cameras.bodies import paste
from backend_clients.simulator.cameras.crops import outcome_of, weeds_near
from backend_clients.simulator.cameras.eye import Eye
from backend_clients.simulator.cameras.leaves import litter_stamp, weed_stamp
from backend_clients.simulator.cameras.scene import Look, Rows
from backend_clients.simulator.cameras.stage import Stage

REACH_M = 8.0
STEP_M = 0.5
MOST = 32  # in one picture, the nearest
WEED_M = 0.13
LITTER = Rows("litter", 0.2, 0.3, (0.0, 0.0))
LITTER_CLOSE = Rows("litter", 0.2, 1.1, (0.0, 0.0))
LEAST_PX = 4.0


@dataclass(frozen=True, slots=True)
class Spot:
    """A weed in the picture; ``outcome`` as ``crops.outcome_of``. Pixels: left, top, right, bottom."""

    box: tuple[float, float, float, float]
    outcome: int
    score: float
    x_m: float
    y_m: float


def draw_weeds(image: Image.Image, eye: Eye, rows: Rows, look: Look, stage: Stage) -> list[Spot]:
    """Draw the weeds in sight, far ones first; return where they are."""
    ahead = 0.0 if eye.pitch_rad < -1.2 else 4.0
    x, y = eye.x_m + ahead * float(np.cos(eye.yaw_rad)), eye.y_m + ahead * float(np.sin(eye.yaw_rad))
    weeds = stage.weeds(look, rows, round(x / STEP_M) * STEP_M, round(y / STEP_M) * STEP_M, 2.0 if ahead == 0 else 5.5)
    outcome = outcome_of(weeds, look.treated)
    u, v, depth = eye.project(np.column_stack((weeds[:, :2], np.full(len(weeds), 0.03))))
    found = []
    order = np.flatnonzero((depth > 0.4) & (depth < REACH_M) & (np.abs(u - eye.width_px / 2) < eye.width_px * 0.6))
    order = order[np.argsort(depth[order])][:MOST]
    for n in order[::-1].tolist():
        wide = WEED_M * float(weeds[n, 2]) * eye.focal_px / float(depth[n])
        steep = min(eye.z_m / float(depth[n]), 1.0)
        high = wide * min(steep + 0.3, 1.0)
        box = (float(u[n]) - wide / 2, float(v[n]) - high / 2, float(u[n]) + wide / 2, float(v[n]) + high / 2)
        if wide < LEAST_PX or box[2] < 0 or box[0] > eye.width_px or box[3] < 0 or box[1] > eye.height_px:
            continue
        state = int(outcome[n])
        paste(image, weed_stamp(int(weeds[n, 3] * 6), 1 if state == 1 else 0), box[0], box[1], wide, high)
        cut = (max(box[0], 0.0), max(box[1], 0.0), min(box[2], eye.width_px), min(box[3], eye.height_px))
        score = 0.99 - 0.2 * float(weeds[n, 4]) - 0.02 * float(depth[n])
        found.append(Spot(cut, state, score, float(weeds[n, 0]), float(weeds[n, 1])))
    return found


def draw_litter(image: Image.Image, eye: Eye, stage: Stage, *, is_close: bool) -> None:
    """Draw tufts, twigs and stones where no crop stands: on forest ground, the same at every look."""
    ahead = 0.0 if eye.pitch_rad < -1.2 else 4.5
    x, y = eye.x_m + ahead * float(np.cos(eye.yaw_rad)), eye.y_m + ahead * float(np.sin(eye.yaw_rad))
    if stage.ground_at(x, y) != "forest":
        return
    many = weeds_near(LITTER_CLOSE if is_close else LITTER, x, y, 1.2 if is_close else 6.5)
    u, v, depth = eye.project(np.column_stack((many[:, :2], np.full(len(many), 0.04))))
    order = np.flatnonzero((depth > 0.3) & (np.abs(u - eye.width_px / 2) < eye.width_px * 0.6))
    for n in order[np.argsort(-depth[order])][-MOST:].tolist():
        size_m = (0.05 if is_close else 0.2) * float(many[n, 2])
        wide = size_m * eye.focal_px / float(depth[n])
        steep = min(eye.z_m / float(depth[n]), 1.0)
        if wide >= LEAST_PX and stage.ground_at(float(many[n, 0]), float(many[n, 1])) == "forest":
            high = wide * min(steep + 0.25, 1.0)
            stamp = litter_stamp(int(many[n, 3] * 6), is_close=is_close)
            paste(image, stamp, float(u[n]) - wide / 2, float(v[n]) - high / 2, wide, high)
