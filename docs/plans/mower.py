"""A robot that is not ours, in plain JSON: an orchard mower with a mast, for ``docs/describe_your_robot.md``.

Nothing of Headland is imported: what is written here is all that a robot has to say to be seen on every screen.
It listens to nothing, so a STOP at it stays NOT CONFIRMED.

python docs/plans/mower.py --broker mqtt://127.0.0.1:1883
python docs/plans/mower.py --model mower.zip
"""

from __future__ import annotations

import argparse
import json
import math
import struct
import time
import uuid
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

ROBOT = "mower-7"
LAT_DEG, LON_DEG = 51.7858, 4.262  # on the demo farm; elsewhere it is outside its fence
STRIP_M, SPEED_MPS = 20.0, 0.5
ROW_S, TURN_S, LOOK_S = 10.0, 3.0, 4.0
Said = tuple[str, dict[str, Any]]

CHART = {
    "states": [
        {"id": "idle", "label": "Idle", "is_initial": True},
        {"id": "mow", "label": "Mow", "kind": "parallel"},
        {"id": "drive", "label": "Drive", "kind": "region", "parent": "mow"},
        {"id": "row", "label": "Row", "parent": "drive", "is_initial": True, "subsystem": "Drive", "normal_s": ROW_S},
        {"id": "turn", "label": "Turn", "parent": "drive", "subsystem": "Drive", "normal_s": TURN_S},
        {"id": "mast", "label": "Mast", "kind": "region", "parent": "mow"},
        {"id": "low", "label": "Low", "parent": "mast", "is_initial": True, "subsystem": "Mast"},
        {"id": "look", "label": "Look", "parent": "mast", "subsystem": "Mast", "normal_s": LOOK_S, "exit": ["Down"]},
    ],
    "transitions": [
        {"source": "idle", "target": "mow", "event": "start"},
        {"source": "row", "target": "turn", "event": "row ends", "guard": "deck up"},
        {"source": "turn", "target": "row", "event": "turned"},
        {"source": "low", "target": "look", "event": "time to look"},
        {"source": "look", "target": "low", "event": "seen"},
    ],
}
FACTSHEET: dict[str, Any] = {
    "family": "other", "name": "Mower 7", "model": "Orchard mower", "software": "2.1",
    "datum": {"lat_deg": LAT_DEG, "lon_deg": LON_DEG},
    "dimensions": {"length_m": 1.8, "width_m": 1.2, "height_m": 0.8, "base_to_front_m": 1.1},
    "limits": {"max_speed_mps": 1.5, "max_accel_mps2": 0.5, "decel_mps2": 1.0, "max_yaw_rate_radps": 1.0},
    "joints": [
        {"name": "mast_lift", "label": "Mast", "unit": "m", "lower": 0, "upper": 1.5, "soft_upper": 1.3, "max_rate": 1},
        {"name": "head_pan", "label": "Head", "lower": -2, "upper": 2, "max_rate": 1},
    ],
    "gauges": [{"key": "blade", "label": "Blade", "unit": "1/min", "lower": 0, "upper": 3000, "ok_lower": 2000}],
    "nodes": [
        {"name": "deck", "label": "Mowing deck", "rate_hz": 20},
        {"name": "diary", "label": "Diary", "starts_after": ["deck"], "period_ms": 60000},
    ],
    "functions": [
        {"name": "follow-path", "label": "Follow path", "depends_on": ["deck"]},
        {"name": "work", "label": "Mow", "depends_on": ["follow-path", "blade"], "better_with": ["diary"]},
    ],
    "chart": CHART,
}  # fmt: skip
STATES = {state["id"]: state for state in CHART["states"]}


class Mower:
    """Makes what one mower says; ``t_s`` is seconds since it was switched on."""

    def __init__(self) -> None:
        self._boot, self._seq = f"mower-{uuid.uuid4()}", 0
        self._since_s: dict[str, float] = {}
        self._newest: dict[str, Any] = {}

    def factsheet(self) -> Said:
        """Who it is; publish it retained."""
        return self._said("factsheet", 0.0, **FACTSHEET)

    def nodes(self, t_s: float) -> Iterator[Said]:
        """What runs in it; publish it retained, each within its period."""
        yield self._said("node", t_s, name="deck", state="started", rate_hz=20.0, cpu_pct=4.0, since_ms=0)
        yield self._said("node", t_s, name="diary", state="started", since_ms=500, period_ms=60000)

    def now(self, t_s: float) -> Iterator[Said]:
        """What it says ten times a second."""
        along = (SPEED_MPS * t_s) % (2 * STRIP_M)
        is_back = along > STRIP_M
        x_m = 2 * STRIP_M - along if is_back else along
        east_deg = x_m / (111_320 * math.cos(math.radians(LAT_DEG)))
        place = {"lat_deg": LAT_DEG, "lon_deg": LON_DEG + east_deg, "x_m": x_m, "y_m": 0.0}
        yield self._said("telemetry", t_s, **place, theta_rad=math.pi if is_back else 0.0, speed_mps=SPEED_MPS)
        joints = {"mast_lift": 0.7 - 0.7 * math.cos(t_s / 2), "head_pan": 1.5 * math.sin(t_s)}
        yield self._said("body", t_s, joints=joints, gauges={"blade": 2500.0})
        yield self._said("heartbeat", t_s, challenge=f"{self._seq:08d}")
        yield self._said(
            "safety", t_s, hardware_stop=False, latched=False, standstill=False, speed_mps=SPEED_MPS, tool_off=False
        )
        yield from self._changes(t_s)
        active = [{"id": one, "since_ms": int(1000 * since_s)} for one, since_s in self._since_s.items()]
        path = [STATES[one]["label"] for one in ("mow", "row", "turn") if one in self._since_s]
        since_ms = max(one["since_ms"] for one in active)
        yield self._said("state", t_s, mode="auto", path=path, path_since_ms=since_ms, active=active, **self._newest)

    def _changes(self, t_s: float) -> Iterator[Said]:
        """States it left and entered, the inner ones left first: durations and shares come from these."""
        leg = "turn" if t_s % (ROW_S + TURN_S) >= ROW_S else "row"
        mast = "look" if t_s % 10 >= 10 - LOOK_S else "low"
        wanted = ("mow", "drive", leg, "mast", mast)
        left = [one for one in self._since_s if one not in wanted]
        entered = [one for one in wanted if one not in self._since_s]
        for one in left:
            duration_ms = int(1000 * (t_s - self._since_s.pop(one)))
            yield self._event("state_left", one, t_s, duration_ms=duration_ms, result="ok")
        for one in entered:
            self._since_s[one] = t_s
            yield self._event("state_entered", one, t_s)
        if left:
            change = {"source": left[-1], "target": entered[-1], "event": "done", "at_ms": int(1000 * t_s)}
            self._newest = {"last_transition": change}

    def _event(self, kind: str, one: str, t_s: float, **more: Any) -> Said:
        state, path = STATES[one], []
        above: Any = one
        while above is not None:
            path.insert(0, STATES[above]["label"])
            above = STATES[above].get("parent")
        is_leaf = not any(other.get("parent") == one for other in CHART["states"])
        data = {"state": one, "path": path, "subsystem": state.get("subsystem", ""), "is_leaf": is_leaf, **more}
        return self._said("event", t_s, event_id=str(uuid.uuid4()), kind=kind, name=state["label"], data=data)

    def _said(self, kind: str, t_s: float, /, **values: Any) -> Said:
        self._seq += 1
        head = {"robot": ROBOT, "boot": self._boot, "seq": self._seq, "mono_ms": int(1000 * t_s)}
        return kind, {**head, "wall_ms": int(time.time() * 1000), **values}


URDF = """<?xml version="1.0"?>
<robot name="mower">
  <material name="green"><color rgba="0.2 0.5 0.2 1"/></material>
  <link name="base_link"><visual><origin xyz="0.2 0 0.4"/><geometry><box size="1.8 1.2 0.5"/></geometry>
    <material name="green"/></visual></link>
  <link name="mast"><visual><origin xyz="0 0 0.5"/><geometry><cylinder radius="0.05" length="1.0"/></geometry></visual>
  </link>
  <link name="head"><visual><geometry><mesh filename="package://mower_description/meshes/head.stl"/></geometry>
    </visual></link>
  <joint name="mast_lift" type="prismatic"><parent link="base_link"/><child link="mast"/><origin xyz="-0.4 0 0.65"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="1.5" effort="1" velocity="1"/></joint>
  <joint name="head_pan" type="revolute"><parent link="mast"/><child link="head"/><origin xyz="0 0 1"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
</robot>
"""


def head_stl() -> bytes:
    """Return the head's mesh: four triangles, binary."""
    a, b, c, d = (0, -0.1, 0), (0, 0.1, 0), (0.3, 0, 0), (0.1, 0, 0.2)
    triangles = [(a, b, d), (b, c, d), (c, a, d), (a, c, b)]
    packed = (struct.pack("<12fH", 0, 0, 0, *(v for point in one for v in point), 0) for one in triangles)
    return b"\0" * 80 + struct.pack("<I", len(triangles)) + b"".join(packed)


def write_model(path: Path) -> None:
    """Write its shape, to be uploaded."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("mower_description/urdf/mower.urdf", URDF)
        archive.writestr("mower_description/meshes/head.stl", head_stl())


def main() -> None:
    """Speak until Ctrl+C, or write the model."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--broker", default="mqtt://127.0.0.1:1883")
    parser.add_argument("--model", type=Path, help="write the URDF zip to this file and end")
    asked = parser.parse_args()
    if asked.model:
        write_model(asked.model)
        return
    from paho.mqtt.client import CallbackAPIVersion, Client

    where, mower = urlsplit(asked.broker), Mower()
    client = Client(CallbackAPIVersion.VERSION2)
    client.connect(where.hostname or "127.0.0.1", where.port or 1883)
    client.loop_start()

    def publish(said: Said, is_kept: bool = False) -> None:
        kind, message = said
        is_sure = is_kept or kind in ("state", "event")
        client.publish(f"headland/v1/{ROBOT}/{kind}", json.dumps(message), qos=int(is_sure), retain=is_kept)

    publish(mower.factsheet(), is_kept=True)
    began_s = time.monotonic()
    for tenth in range(10**9):
        t_s = tenth / 10
        for said in mower.nodes(t_s) if tenth % 20 == 0 else ():
            publish(said, is_kept=True)
        for said in mower.now(t_s):
            publish(said)
        time.sleep(max(0.0, began_s + t_s + 0.1 - time.monotonic()))


if __name__ == "__main__":
    main()
