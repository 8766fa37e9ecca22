"""A robot that is not ours, for ``docs/describe_your_robot.md``: a berry picker that says what it is and moves its arm.

python docs/plans/berry_picker.py --broker mqtt://127.0.0.1:1883
python docs/plans/berry_picker.py --model berry_picker.zip
"""

from __future__ import annotations

import argparse
import math
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import encode
from backend_clients.edge.machine import (
    ActiveState,
    Body,
    Chart,
    ChartState,
    ChartTransition,
    GaugeInfo,
    Joint,
    NodeInfo,
)
from backend_clients.edge.mqtt import MqttLink
from backend_clients.edge.topics import Up, topic

ROBOT = "berry-picker-1"
LAT_DEG, LON_DEG = 51.7858, 4.262  # on the demo farm
CYCLE_S = 6.0
JOINTS = [
    Joint(name="turn", label="1 Turn", lower=-1.6, upper=1.6, soft_lower=-1.5, soft_upper=1.5, max_rate=1.0),
    Joint(name="lift", label="2 Lift", lower=-0.2, upper=1.2, soft_lower=-0.1, soft_upper=1.1, max_rate=0.8),
    Joint(name="reach", label="3 Reach", unit="m", lower=0.0, upper=0.4, max_rate=0.3),
]
CHART = Chart(
    states=[
        ChartState(id="idle", label="Idle", is_initial=True),
        ChartState(id="work", label="Work", kind="composite"),
        ChartState(id="reach", label="Reach", parent="work", is_initial=True, subsystem="Arm", normal_s=4.0),
        ChartState(id="pick", label="Pick", parent="work", subsystem="Gripper", normal_s=2.0),
    ],
    transitions=[
        ChartTransition(source="idle", target="work", event="start"),
        ChartTransition(source="reach", target="pick", event="there"),
        ChartTransition(source="pick", target="reach", event="picked"),
    ],
)
URDF = """<robot name="berry_picker">
  <material name="red"><color rgba="0.7 0.15 0.2 1"/></material>
  <material name="grey"><color rgba="0.3 0.33 0.35 1"/></material>
  <link name="base"><visual><origin xyz="0 0 0.35"/><geometry><box size="1.2 0.8 0.4"/></geometry>
    <material name="red"/></visual></link>
  <link name="post"><visual><origin xyz="0 0 0.2"/><geometry><cylinder radius="0.08" length="0.4"/></geometry>
    <material name="grey"/></visual></link>
  <link name="arm"><visual><origin xyz="0.3 0 0"/><geometry><box size="0.6 0.08 0.08"/></geometry>
    <material name="grey"/></visual></link>
  <link name="tool"><visual><geometry><mesh filename="meshes/hand.obj"/></geometry></visual></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="post"/><origin xyz="0.3 0 0.55"/>
    <axis xyz="0 0 1"/><limit lower="-1.6" upper="1.6"/></joint>
  <joint name="lift" type="revolute"><parent link="post"/><child link="arm"/><origin xyz="0 0 0.4"/>
    <axis xyz="0 -1 0"/><limit lower="-0.2" upper="1.2"/></joint>
  <joint name="reach" type="prismatic"><parent link="arm"/><child link="tool"/><origin xyz="0.6 0 0"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.4"/></joint>
</robot>
"""
HAND = "v 0 -0.06 0\nv 0 0.06 0\nv 0.15 0 0\nv 0.05 0 0.1\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 1 3 2\n"


class BerryPicker:
    """Makes the messages of one berry picker; ``t_s`` is seconds since it was switched on."""

    def __init__(self) -> None:
        self._boot, self._seq = f"berry-{time.time_ns()}", 0

    def factsheet(self) -> bytes:
        """Who it is."""
        size = up.Dimensions(length_m=1.2, width_m=0.8, height_m=0.9, base_to_front_m=0.6)
        limits = up.Limits(max_speed_mps=1.0, max_accel_mps2=0.5, decel_mps2=1.0, max_yaw_rate_radps=1.0)
        gauge = GaugeInfo(key="crate", label="Crate", unit="kg", lower=0.0, upper=20.0, ok_upper=18.0)
        nodes = [NodeInfo(name="arm", label="Arm"), NodeInfo(name="eyes", label="Eyes", starts_after=["arm"])]
        return self._said(
            up.Factsheet, 0.0, family="other", name="Berry picker 1", model="Berry picker", software="0.3",
            datum=up.Datum(lat_deg=LAT_DEG, lon_deg=LON_DEG), dimensions=size, limits=limits, joints=JOINTS,
            gauges=[gauge], nodes=nodes, chart=CHART,
        )  # fmt: skip

    def now(self, t_s: float) -> Iterator[tuple[Up, bytes]]:
        """Yield what it says at a moment."""
        swing = math.sin(2 * math.pi * t_s / CYCLE_S)
        joints = {"turn": 1.2 * swing, "lift": 0.5 + 0.4 * swing, "reach": 0.2 + 0.2 * swing}
        x_m = 0.2 * t_s
        place = {"lat_deg": LAT_DEG, "lon_deg": LON_DEG + x_m / 68_600, "x_m": x_m, "y_m": 0.0, "theta_rad": 0.0}
        yield Up.TELEMETRY, self._said(up.Telemetry, t_s, **place, speed_mps=0.2)
        yield Up.BODY, self._said(Body, t_s, joints=joints, gauges={"crate": 3.0 + 0.01 * t_s})
        yield Up.HEARTBEAT, self._said(up.Heartbeat, t_s, challenge=f"{self._seq:08d}")
        leaf = "pick" if t_s % CYCLE_S > 4 else "reach"
        active = [ActiveState(id="work", since_ms=0), ActiveState(id=leaf, since_ms=int(1000 * (t_s - t_s % 2)))]
        labels = ["Work", leaf.capitalize()]
        yield Up.STATE, self._said(up.State, t_s, mode="auto", path=labels, path_since_ms=0, active=active)

    def _said(self, form: type[up.Header], t_s: float, **values: Any) -> bytes:
        self._seq += 1
        head = {"robot": ROBOT, "boot": self._boot, "seq": self._seq, "mono_ms": int(1000 * t_s)}
        return encode(form(**head, wall_ms=int(time.time() * 1000), **values))


def write_model(path: Path) -> None:
    """Write its shape, to be uploaded."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("berry_picker/robot.urdf", URDF)
        archive.writestr("berry_picker/meshes/hand.obj", HAND)


def main() -> None:
    """Speak until Ctrl+C, or write the model."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--broker", default="mqtt://127.0.0.1:1883")
    parser.add_argument("--model", type=Path, help="write the URDF zip to this file and end")
    asked = parser.parse_args()
    if asked.model:
        write_model(asked.model)
        return
    picker, link = BerryPicker(), MqttLink(asked.broker, "berry-picker")
    link.start()
    began_s = time.monotonic()
    while True:
        if int(10 * (time.monotonic() - began_s)) % 50 == 0:
            link.publish(topic(ROBOT, Up.FACTSHEET), picker.factsheet(), qos=1, retain=True)
        for kind, payload in picker.now(time.monotonic() - began_s):
            link.publish(topic(ROBOT, kind), payload)
        time.sleep(0.1)


if __name__ == "__main__":
    main()
