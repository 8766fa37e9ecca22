"""The point cloud of a laser scanner."""

from __future__ import annotations

import base64
import binascii

import numpy as np
import viser
from numpy.typing import NDArray

from backend_clients.edge.machine import MAX_SCAN_POINTS, Scan

INK = (62, 74, 82)
POINT_M = 0.05


def points_of(scan: Scan) -> NDArray[np.float32]:
    """Return (N, 3) metres in the robot's plane; none for a broken scan."""
    try:
        raw = base64.b64decode(scan.points, validate=True)
    except (binascii.Error, ValueError):
        return np.empty((0, 3), np.float32)
    whole = len(raw) // 6 * 6
    offsets = np.frombuffer(raw[:whole], "<i2").reshape(-1, 3)[:MAX_SCAN_POINTS].astype(np.float64) / 100
    return np.asarray(offsets + np.asarray(scan.origin), dtype=np.float32)


def draw_scan(scene: viser.SceneApi, name: str, scan: Scan, shift: tuple[float, float]) -> int:
    """Draw a scan in place of the one before; return how many points it has."""
    points = points_of(scan)
    if len(points) == 0:
        scene.remove_by_name(name)
        return 0
    moved = points + np.asarray((*shift, 0.0), np.float32)
    # float16 would put points 1 km from the origin half a metre aside
    scene.add_point_cloud(
        name, moved, INK, point_size=POINT_M, point_shape="circle", point_shading="flat", precision="float32"
    )
    return len(points)
