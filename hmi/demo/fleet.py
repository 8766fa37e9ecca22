"""The robots of the demo: who they are, where they stand, and the file from which the simulator starts them."""

from __future__ import annotations

import json
import math
import os
import secrets
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hmi.demo.farm import feature
from hmi.planning.projection import LocalFrame

FILE = Path("run") / "demo-robots.json"


@dataclass(frozen=True, slots=True)
class DemoRobot:
    """One simulated weeder: identity, site datum (WGS84) and the home bay it stands in."""

    id: str
    name: str
    home_id: str
    datum_lat_deg: float
    datum_lon_deg: float
    contact_name: str
    contact_phone: str
    soc: float = 0.92

    @property
    def home(self) -> tuple[float, float]:
        """Longitude and latitude of its bay."""
        lon, lat = feature(self.home_id).geometry["coordinates"]
        return float(lon), float(lat)

    def pose(self) -> tuple[float, float, float]:
        """Return x, y (metres in the plane of its datum) and ENU yaw in its bay."""
        x, y = LocalFrame(self.datum_lat_deg, self.datum_lon_deg).to_local([self.home])[0]
        bearing = math.radians(float(feature(self.home_id).properties["heading_deg"]))
        return float(x), float(y), math.pi / 2 - bearing


POLDER_DATUM = (51.7858, 4.262)
SITE_DATUM = (40.312546, -3.48086)
ROBOTS = (
    DemoRobot("weeder-01", "Weeder 01", "polder-bay-1", *POLDER_DATUM, "Jonas Weber", "+31 6 0000 0001"),
    DemoRobot("weeder-02", "Weeder 02", "polder-bay-2", *POLDER_DATUM, "Jonas Weber", "+31 6 0000 0001", soc=0.81),
    DemoRobot("weeder-03", "Weeder 03", "site-home", *SITE_DATUM, "Lucia Romero", "+34 600 000 003"),
)


def robot(robot_id: str) -> DemoRobot:
    """Return one robot of the demo.

    Raises:
        KeyError: there is none of this id.
    """
    return {one.id: one for one in ROBOTS}[robot_id]


def write_demo_fleet(data: Path, base_url: str) -> Path:
    """Write the file the simulator and the console start from; return its path.

    Tokens are made once and kept. Each row is a simulated weeder with ``http_url`` beside it.

    Args:
        data: the data folder.
        base_url: where the simulator serves robot HTTP, e.g. ``http://127.0.0.1:9000``.
    """
    path = data / FILE
    tokens = {row["id"]: row["token"] for row in read_demo_fleet(data)}
    rows = [_row(one, tokens.get(one.id) or secrets.token_urlsafe(24), base_url) for one in ROBOTS]
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=path.name)  # private: it holds tokens
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        json.dump(rows, file, indent=1)
    Path(name).replace(path)
    return path


def read_demo_fleet(data: Path) -> list[dict[str, Any]]:
    """Return the rows that ``write_demo_fleet`` wrote, empty if there are none."""
    try:
        rows: list[dict[str, Any]] = json.loads((data / FILE).read_text("utf-8"))
    except (OSError, ValueError):
        return []
    return rows


def _row(one: DemoRobot, token: str, base_url: str) -> dict[str, Any]:
    x, y, theta = one.pose()
    return {
        "id": one.id,
        "name": one.name,
        "token": token,
        "http_url": f"{base_url.rstrip('/')}/{one.id}",
        "datum_lat_deg": one.datum_lat_deg,
        "datum_lon_deg": one.datum_lon_deg,
        "x_m": round(x, 3),
        "y_m": round(y, 3),
        "theta_rad": round(math.remainder(theta, 2 * math.pi), 4),
        "soc": one.soc,
    }
