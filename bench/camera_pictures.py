"""What pictures of the simulated cameras cost: CPU for drawing and JPEG of one, beside a plain JPEG of a still.

The scene is a field of beet with somebody ahead, weeds, a hedge and a barn; textures are there already.
"""

from __future__ import annotations

import math
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

from backend_clients.simulator.cameras.composer import compose
from backend_clients.simulator.cameras.jpeg import encoded
from backend_clients.simulator.cameras.painter import Painter
from backend_clients.simulator.cameras.scene import Ground, Look, Rows, Scene, Solid, Thing
from backend_clients.simulator.cameras.stage import Stage
from backend_clients.simulator.cameras.studio import environment

ROUNDS = 60
NOON_MS = 1_779_278_400_000
BEARING = 1.2
ROWS = Rows("Sugar beet", 0.5, BEARING, (0.0, 0.0))
HEDGE = Solid("hedge", [(-90, 92), (90, 92), (90, 95), (-90, 95)], 3.0)
BARN = Solid("building", [(20, 96), (40, 96), (40, 104), (20, 104)], 5.0)
GROUND = Ground("field", [(-90, -90), (90, -90), (90, 90), (-90, 90)], ROWS)
SCENE = Scene("bench", 51.8, 4.3, [GROUND], [HEDGE, BARN])
SIZES = (("camera_picture_640_ms", 640, 480), ("camera_picture_2048_ms", 2048, 1536))
CONDITIONS = "weeder's front camera, field of beet with somebody ahead, CPU time of drawing and JPEG, median"


def run() -> Iterator[dict[str, Any]]:
    """Measure in a process with the memory settings of the drawing process."""
    code = "from bench.camera_pictures import measure; measure()"
    done = subprocess.run([sys.executable, "-c", code], env=environment(), capture_output=True, text=True, check=True)
    for (name, _, _), line in zip(SIZES, done.stdout.splitlines(), strict=True):
        total, plain = (float(part) for part in line.split())
        ratio = round(total / plain, 1)
        yield {"name": name, "value": total, "unit": "ms", "naive": plain, "ratio": ratio, "conditions": CONDITIONS}


def measure() -> None:
    """Print for each size the milliseconds of a picture and of its JPEG alone."""
    stage, painter = Stage(SCENE), Painter()
    painter.keep(SCENE)
    for _, wide, high in SIZES:
        pixels, _ = compose(_look(wide, high, 0), stage)
        looks = [_look(wide, high, n) for n in range(ROUNDS)]
        whole = statistics.median(_ms(painter.draw, n, one) for n, one in enumerate(looks))
        plain = statistics.median(_ms(encoded, pixels) for _ in looks)
        sys.stdout.write(f"{whole:.1f} {plain:.1f}\n")


def _ms(work: Callable[..., object], *arguments: object) -> float:
    begin = time.process_time()
    work(*arguments)
    return (time.process_time() - begin) * 1000


def _look(wide: int, high: int, n: int) -> Look:
    """Return the picture after driving ``n`` steps of 7 cm."""
    cos, sin = math.cos(BEARING), math.sin(BEARING)
    x, y = n * 0.07 * cos, n * 0.07 * sin
    somebody = Thing("person", x + 8 * cos, y + 8 * sin)
    return Look("bench", "weeder-01", "front", "weeder", wide, high, NOON_MS + n * 66, x, y, BEARING, tilt_rad=-0.32,
                is_tool_on=True, things=[somebody])  # fmt: skip
