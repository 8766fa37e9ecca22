"""Shows a URDF in the twin before its robot can speak: every joint swings between its limits, one after the other.

python docs/plans/any_urdf.py panda.zip --broker mqtt://127.0.0.1:1883
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import encode
from backend_clients.edge.machine import Body, Joint
from backend_clients.edge.mqtt import MqttLink
from backend_clients.edge.topics import Up, topic
from hmi.twin.model import ModelJoint
from hmi.twin.upload import load_kept, read_upload

SWING_S = 2.0
LAT_DEG, LON_DEG = 51.7858, 4.262  # on the demo farm


class AnyRobot:
    """Makes the messages of a robot that stands and moves its joints; ``t_s`` is seconds since it was switched on."""

    def __init__(self, robot_id: str, name: str, joints: Sequence[ModelJoint]) -> None:
        self.id, self._name = robot_id, name
        self._joints = [_declared(one) for one in joints if one.moves and one.mimic is None][:64]
        self._boot, self._seq = f"any-{time.time_ns()}", 0

    def factsheet(self) -> bytes:
        """Who it is; its size is not known from a URDF, so that of a small machine is told."""
        size = up.Dimensions(length_m=1.2, width_m=0.8, height_m=1.0, base_to_front_m=0.6)
        limits = up.Limits(max_speed_mps=1.0, max_accel_mps2=0.5, decel_mps2=1.0, max_yaw_rate_radps=1.0)
        return self._said(
            up.Factsheet, 0.0, family="other", name=self._name, model=self._name, software="0",
            datum=up.Datum(lat_deg=LAT_DEG, lon_deg=LON_DEG), dimensions=size, limits=limits, joints=self._joints,
        )  # fmt: skip

    def now(self, t_s: float) -> Iterator[tuple[Up, bytes]]:
        """Yield what it says at a moment."""
        place = {"lat_deg": LAT_DEG, "lon_deg": LON_DEG, "x_m": 0.0, "y_m": 0.0, "theta_rad": 0.0}
        yield Up.TELEMETRY, self._said(up.Telemetry, t_s, **place, speed_mps=0.0)
        yield Up.BODY, self._said(Body, t_s, joints=self.joints(t_s))
        yield Up.HEARTBEAT, self._said(up.Heartbeat, t_s, challenge=f"{self._seq:08d}")
        yield Up.STATE, self._said(up.State, t_s, mode="auto", path=["Swing"], path_since_ms=0)

    def joints(self, t_s: float) -> dict[str, float]:
        """Return where the joints are: all at rest but one."""
        turn = int(t_s / SWING_S) % max(1, len(self._joints))
        swing = 0.5 - 0.5 * math.cos(2 * math.pi * (t_s % SWING_S) / SWING_S)
        return {
            one.name: _rest(one) + (one.upper - _rest(one)) * (swing if number == turn else 0.0)
            for number, one in enumerate(self._joints)
        }

    def _said(self, form: type[up.Header], t_s: float, **values: Any) -> bytes:
        self._seq += 1
        head = {"robot": self.id, "boot": self._boot, "seq": self._seq, "mono_ms": int(1000 * t_s)}
        return encode(form(**head, wall_ms=int(time.time() * 1000), **values))


def joints_of(archive: Path) -> tuple[str, Sequence[ModelJoint], list[str]]:
    """Return name, joints and what is missing of a zip as the upload reads it; raises ``ModelError``."""
    with tempfile.TemporaryDirectory() as folder:
        read_upload(archive, Path(folder) / "kept")
        model, _ = load_kept(Path(folder) / "kept")
    return model.name, model.joints, list(model.notices)


def main() -> None:
    """Speak until Ctrl+C."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", type=Path, help="the zip of URDF and meshes that will be uploaded")
    parser.add_argument("--broker", default="mqtt://127.0.0.1:1883")
    parser.add_argument("--id", default="any-urdf-1")
    asked = parser.parse_args()
    name, joints, notices = joints_of(asked.model)
    robot, link = AnyRobot(asked.id, name, joints), MqttLink(asked.broker, asked.id)
    sys.stdout.write("\n".join([f"{name}: {len(joints)} joints", *notices, ""]))
    link.start()
    began_s = time.monotonic()
    while True:
        if int(10 * (time.monotonic() - began_s)) % 50 == 0:
            link.publish(topic(robot.id, Up.FACTSHEET), robot.factsheet(), qos=1, retain=True)
        for kind, payload in robot.now(time.monotonic() - began_s):
            link.publish(topic(robot.id, kind), payload)
        time.sleep(0.1)


def _declared(joint: ModelJoint) -> Joint:
    lower = -math.pi if joint.lower is None else joint.lower
    upper = math.pi if joint.upper is None else joint.upper
    unit: Any = "m" if joint.kind == "prismatic" else "rad"
    return Joint(name=joint.name, label=joint.name, unit=unit, lower=lower, upper=max(upper, lower), max_rate=1.0)


def _rest(joint: Joint) -> float:
    return min(max(0.0, joint.lower), joint.upper)


if __name__ == "__main__":
    main()
