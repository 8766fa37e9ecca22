"""Import: a GeoJSON file of 20 MB, from the bytes in the console to shapes somebody can choose from.

Prints ``import_20mb_s`` (the whole way, the process it is read in included), ``import_20mb_mb`` (memory of that process
at its worst) and ``import_20mb_stall_ms`` (the longest the console's event loop stood still meanwhile).
The naive way reads in the console itself: its stall is the whole reading, in which nobody is served.
"""

from __future__ import annotations

import asyncio
import json
import math
import resource
import sys
import time
from collections.abc import Iterator
from typing import Any

from hmi.map_files.progress import Progress
from hmi.map_files.reader import read_map
from hmi.map_files.worker import MapReader

BYTES = 20_000_000
CORNERS = 60  # of a parcel as surveyors draw it
TICK_S = 0.005
PATIENT_S = 900.0  # a busy machine is measured too; the console gives up after 120 s
LON, LAT = 4.3, 51.7


def large_map(size: int = BYTES) -> bytes:
    """Return a district as GeoJSON: parcels with attributes, 15 digits a coordinate as most programs write them."""
    features: list[str] = []
    written, n = 0, 0
    while written < size:
        text = json.dumps(_parcel(n))
        features.append(text)
        written += len(text) + 1
        n += 1
    return b'{"type": "FeatureCollection", "features": [' + ",".join(features).encode() + b"]}"


def _parcel(n: int) -> dict[str, Any]:
    lon, lat = LON + n % 100 * 0.003, LAT + n // 100 * 0.002
    turns = [2 * math.pi * k / CORNERS for k in range(CORNERS)]
    wobble = [1 + 0.1 * math.sin(7 * turn + n) for turn in turns]
    ring = [
        [lon + 0.0012 * w * math.cos(turn), lat + 0.0008 * w * math.sin(turn)]
        for turn, w in zip(turns, wobble, strict=True)
    ]
    told = {"name": f"Perceel {n}", "gewas": "Suikerbieten", "area": 12_345.6, "code": f"NL-{n:06d}", "year": 2026}
    geometry = {"type": "Polygon", "coordinates": [[*ring, ring[0]]]}
    return {"type": "Feature", "properties": told, "geometry": geometry}


async def _ours(data: bytes) -> dict[str, Any]:
    reader = MapReader(limit_s=PATIENT_S)
    stalls: list[float] = []
    told: list[Progress] = []
    watch = asyncio.create_task(_watched(stalls))
    await asyncio.sleep(0.05)
    stalls.clear()
    start = time.perf_counter()
    imported = await reader.read(data, "district.geojson", told.append)
    seconds = time.perf_counter() - start
    watch.cancel()
    await reader.close()
    return {"s": seconds, "stall_ms": max(stalls) * 1000, "shapes": len(imported.items), "told": len(told)}


async def _watched(stalls: list[float]) -> None:
    while True:
        before = time.perf_counter()
        await asyncio.sleep(TICK_S)
        stalls.append(time.perf_counter() - before - TICK_S)


def run(wanted: str | None = None) -> Iterator[dict[str, Any]]:
    """Yield the three figures."""
    data = large_map()
    ours = asyncio.run(_ours(data))
    peak_mb = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024  # Linux counts kilobytes
    start = time.perf_counter()
    read_map(data, "district.geojson")
    naive_s = time.perf_counter() - start
    conditions = f"{len(data) / 1e6:.0f} MB GeoJSON, {ours['shapes']} parcels, progress told {ours['told']} times"
    figures = [
        ("import_20mb_s", round(ours["s"], 2), "s", round(naive_s, 2)),
        ("import_20mb_mb", round(peak_mb), "MB", None),
        ("import_20mb_stall_ms", round(ours["stall_ms"]), "ms", round(naive_s * 1000)),
    ]
    for name, value, unit, naive in figures:
        if wanted in (None, name):
            ratio = round(naive / value, 1) if naive and value else None
            yield {"name": name, "value": value, "unit": unit, "naive": naive, "ratio": ratio, "conditions": conditions}


def main() -> int:
    """Print the figures as JSON lines."""
    for figure in run():
        print(json.dumps(figure), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
