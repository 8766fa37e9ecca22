"""Where each camera sits on its machine, how it looks, and which software node it needs.

The links ``camera_...`` of the models in ``static/models`` stand at the same places: what the twin shows there is seen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from backend_clients.simulator.cameras.eye import Eye
from backend_clients.simulator.cameras.scene import Look

DOWN = -math.pi / 2
PITCH_STEP_RAD = 0.001  # less than a pixel; what was found for one pitch serves the next picture
View = Literal["front", "rear", "side", "tool", "head", "nadir", "distance"]


@dataclass(frozen=True, slots=True)
class Mount:
    """One camera. Metres from the machine's reference point, radians; ``pitch`` is above the horizon.

    Args:
        node: without which it gives no picture.
        is_on_head: it turns with the joints pan and tilt.
        is_on_crane: it hangs at the crane's tip.
        lamp_m: how far its lamp reaches; 0 has none.
        shade: the machine's own parts that are in its view.
    """

    forward_m: float
    left_m: float
    up_m: float
    yaw_rad: float
    pitch_rad: float
    fov_deg: float
    node: str
    kind: Literal["colour", "infrared", "depth"] = "colour"
    view: View = "front"
    is_on_head: bool = False
    is_on_crane: bool = False
    lamp_m: float = 9.0

    def eye(self, look: Look, width_px: int, height_px: int) -> Eye:
        """Return the camera as it looks now."""
        yaw, pitch = look.theta_rad + self.yaw_rad, self.pitch_rad + look.lean_rad * math.cos(self.yaw_rad)
        x, y, z = self.place(look)
        if self.is_on_crane and look.crane is not None:
            yaw = look.crane.heading_rad
        elif self.is_on_head:
            yaw, pitch = yaw + look.pan_rad, pitch + look.tilt_rad
        focal = width_px / 2 / math.tan(math.radians(self.fov_deg) / 2) * max(look.zoom, 1.0)
        pitch = round(max(pitch, DOWN) / PITCH_STEP_RAD) * PITCH_STEP_RAD
        return Eye(x, y, round(max(z, 0.15), 2), yaw, pitch, width_px, height_px, focal)

    def place(self, look: Look) -> tuple[float, float, float]:
        """Return where it is, ENU and above the ground."""
        if self.is_on_crane and look.crane is not None:
            x, y, z = look.crane.joints[-1]
            return x, y, z + self.up_m
        cos, sin = math.cos(look.theta_rad), math.sin(look.theta_rad)
        x = look.x_m + self.forward_m * cos - self.left_m * sin
        y = look.y_m + self.forward_m * sin + self.left_m * cos
        return x, y, look.z_m + self.up_m


MOUNTS: dict[tuple[str, str], Mount] = {
    ("weeder", "front"): Mount(0.52, 0.0, 1.45, 0.0, 0.0, 74.0, "perception", is_on_head=True),
    ("weeder", "rear"): Mount(-1.15, 0.0, 1.55, math.pi, -0.42, 74.0, "perception", view="rear"),
    ("weeder", "side"): Mount(
        0.2, -0.75, 1.5, -math.pi / 2, -0.3, 74.0, "perception", kind="infrared", view="front", lamp_m=14.0
    ),
    ("weeder", "tool"): Mount(-0.62, 0.0, 1.15, 0.0, DOWN, 72.0, "perception", view="tool", lamp_m=4.0),
    ("weeder", "tof"): Mount(
        0.52, 0.0, 1.37, 0.0, -0.2, 62.0, "perception", kind="depth", view="distance", is_on_head=True, lamp_m=0.0
    ),
    ("planter", "rear"): Mount(-1.6, 0.6, 3.1, math.pi, -0.44, 82.0, "stereo", view="rear", lamp_m=16.0),
    ("planter", "head"): Mount(0.0, 0.0, 1.15, 0.0, DOWN, 62.0, "planter", view="head", is_on_crane=True, lamp_m=4.0),
    ("uav", "gimbal"): Mount(0.1, 0.0, 0.12, 0.0, 0.0, 78.0, "camera", view="nadir", is_on_head=True, lamp_m=0.0),
}
