"""The robots of the demo: who they are, where they stand, and the file from which the simulator starts them."""

from __future__ import annotations

import json
import math
import os
import secrets
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from hmi.demo.farm import feature
from hmi.domain.family import Family

FILE = Path("run") / "demo-robots.json"


FleetSize = Literal["full", "small"]
POLDER_DATUM = (51.7858, 4.262)
MECHANIC = ("Jonas Weber", "+31 6 0000 0001")
FORESTER = ("Sanne de Wit", "+31 6 0000 0002")
PILOT = ("Lucia Romero", "+31 6 0000 0003")


@dataclass(frozen=True, slots=True)
class DemoRobot:
    """One simulated robot: identity, who looks after it, and the home bay it stands in. ``soc`` is at first start."""

    id: str
    name: str
    home_id: str
    contact: tuple[str, str] = MECHANIC
    soc: float = 0.92
    family: Family = Family.WEEDER
    datum_lat_deg: float = POLDER_DATUM[0]
    datum_lon_deg: float = POLDER_DATUM[1]

    @property
    def home(self) -> tuple[float, float]:
        """Longitude and latitude of its bay."""
        lon, lat = feature(self.home_id).geometry["coordinates"]
        return float(lon), float(lat)

    def pose(self) -> tuple[float, float, float]:
        """Return x, y (metres in the plane of its datum) and ENU yaw in its bay."""
        from hmi.planning.projection import LocalFrame  # takes half a second to import, and a known place is kept

        x, y = LocalFrame(self.datum_lat_deg, self.datum_lon_deg).to_local([self.home])[0]
        bearing = math.radians(float(feature(self.home_id).properties["heading_deg"]))
        return float(x), float(y), math.pi / 2 - bearing


SMALL = (
    DemoRobot("weeder-01", "Weeder 01", "polder-bay-1"),
    DemoRobot("weeder-02", "Weeder 02", "polder-bay-2", soc=0.81),
    DemoRobot("weeder-03", "Weeder 03", "bay-03", soc=0.88),
)
"""Enough to try one thing: nothing happens by itself."""
_CHARGE = {4: 0.77, 5: 0.64, 6: 0.71, 7: 0.68, 8: 0.83, 9: 0.63, 10: 0.74, 11: 0.71, 12: 0.59, 13: 0.95, 14: 1.0,
           15: 0.46, 16: 0.31}  # fmt: skip
FULL = (
    *SMALL,
    *(DemoRobot(f"weeder-{n:02d}", f"Weeder {n:02d}", f"bay-{n:02d}", soc=soc) for n, soc in _CHARGE.items()),
    *(
        DemoRobot(f"planter-{n:02d}", f"Planter {n:02d}", f"planter-bay-{n}", FORESTER, soc, Family.PLANTER)
        for n, soc in ((1, 0.82), (2, 0.54), (3, 0.66), (4, 1.0))
    ),
    *(
        DemoRobot(f"uav-{n:02d}", f"Kestrel {n}", f"uav-pad-{n}", PILOT, soc, Family.UAV)
        for n, soc in ((1, 0.97), (2, 0.88), (3, 0.52), (4, 1.0))
    ),
)
"""The whole farm at work: 16 weeders, 4 planters, 4 UAVs. weeder-01 and weeder-02 wait for whoever tries the demo."""


def demo_robots(size: FleetSize = "full") -> tuple[DemoRobot, ...]:
    """Return the robots of a fleet."""
    return FULL if size == "full" else SMALL


def robot(robot_id: str) -> DemoRobot:
    """Return one robot of the demo.

    Raises:
        KeyError: there is none of this id.
    """
    return {one.id: one for one in FULL}[robot_id]


def write_demo_fleet(data: Path, base_url: str, size: FleetSize = "full") -> Path:
    """Write the file the simulator and the console start from; return its path.

    Tokens are made once and kept. Each row is a simulated robot with ``http_url`` beside it.

    Args:
        data: the data folder.
        base_url: where the simulator serves robot HTTP, e.g. ``http://127.0.0.1:9000``.
        size: which robots.
    """
    path = data / FILE
    known = {row["id"]: row for row in read_demo_fleet(data)}
    rows = []
    for one in demo_robots(size):
        before = known.get(one.id, {})
        rows.append(row_of(one, before.get("token") or secrets.token_urlsafe(24), base_url, before))
    for row in rows:
        row["task"] = size == "full"  # a small fleet waits for whoever tries it
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


def row_of(one: DemoRobot, token: str, base_url: str, before: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return a row of the fleet file; ``before`` is the robot's row of the last start."""
    home = [*one.home, one.datum_lat_deg, one.datum_lon_deg]
    is_known = before is not None and before.get("home") == home
    place = {key: before[key] for key in ("x_m", "y_m", "theta_rad")} if is_known and before else _place(one)
    return {
        "id": one.id,
        "name": one.name,
        "family": one.family.value,
        "token": token,
        "http_url": f"{base_url.rstrip('/')}/{one.id}",
        "datum_lat_deg": one.datum_lat_deg,
        "datum_lon_deg": one.datum_lon_deg,
        "home": home,
        **place,
        "soc": one.soc,
    }


def _place(one: DemoRobot) -> dict[str, float]:
    x, y, theta = one.pose()
    return {
        "x_m": round(x, 3),
        "y_m": round(y, 3),
        "theta_rad": round(math.remainder(theta, 2 * math.pi), 4),
    }
