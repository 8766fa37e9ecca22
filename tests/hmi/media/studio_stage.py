"""What tests of the media process share: a planter that speaks when told, and a viewer's picture."""

from __future__ import annotations

import asyncio
from typing import Any

import msgspec
import websockets.asyncio.client
import zstandard
from websockets.typing import Subprotocol

from backend_clients.edge import machine
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import encode
from backend_clients.edge.machine import Joint, Sighting
from backend_clients.edge.topics import Up, topic
from hmi.media.door import SECRET_HEADER, VIEWER_HEADER
from hmi.media.intake import Intake
from hmi.media.studio import Studio

SECRET = "the secret of this test"
ROBOT, OTHER = "planter-02", "planter-03"
HEADER: dict[str, Any] = {"robot": ROBOT, "boot": "boot-0001", "wall_ms": 0}
JOINTS = [
    Joint(name="slew", label="1 Slew", lower=-3.0, upper=3.0, max_rate=0.4),
    Joint(name="stick", label="3 Stick", lower=-2.7, upper=-0.15, soft_lower=-2.57, soft_upper=-0.28, max_rate=0.3),
]


class Planter:
    """A planter that speaks when told."""

    def __init__(self, intake: Intake, robot: str = ROBOT) -> None:
        self._intake, self._mono_ms, self._robot = intake, 0, robot

    def say(self, kind: Up, form: type[up.Header], **values: Any) -> None:
        """Say something."""
        self._mono_ms += 100
        message = form(**HEADER | {"robot": self._robot}, seq=self._mono_ms, mono_ms=self._mono_ms, **values)
        self._intake.take(topic(self._robot, kind), encode(message), False)

    def rest(self, seconds: float) -> None:
        """Let its clock run."""
        self._mono_ms += round(1000 * seconds)

    def stand(self, x_m: float, slew: float = 0.0, stick: float = -1.0) -> None:
        """Stand somewhere, the crane so."""
        place = {"lat_deg": 52.0, "lon_deg": 5.0, "x_m": x_m, "y_m": 0.0, "theta_rad": 0.0, "speed_mps": 0.0}
        self.say(Up.TELEMETRY, up.Telemetry, **place)
        near = Sighting(id="p1", kind="person", x_m=x_m + 5, y_m=0.0, distance_m=5.0)
        joints = {"slew": slew, "stick": stick}
        self.say(Up.BODY, machine.Body, joints=joints, planned={"slew": slew + 0.3}, seen=[near])

    def introduce(self, **more: Any) -> None:
        """Say who it is."""
        size = up.Dimensions(length_m=6.4, width_m=2.6, height_m=3.2, base_to_front_m=4.0)
        limits = up.Limits(max_speed_mps=2.0, max_accel_mps2=1.0, decel_mps2=1.0, max_yaw_rate_radps=1.0)
        self.say(
            Up.FACTSHEET, up.Factsheet, family="planter", name="Planter 02", model="Planter", software="1",
            datum=up.Datum(lat_deg=52.0, lon_deg=5.0), dimensions=size, limits=limits, **{"joints": JOINTS, **more},
        )  # fmt: skip


class Picture:
    """A browser's picture: nodes as viser's client would hold them."""

    def __init__(self, socket: websockets.asyncio.client.ClientConnection) -> None:
        self._socket = socket
        self.nodes: dict[str, dict[str, Any]] = {}

    async def look(self) -> None:
        """Say where the camera is, as a browser does at first."""
        camera = {
            "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (3.0, 3.0, 3.0), "fov": 1.0,
            "near": 0.01, "far": 1000.0, "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0),
            "image_height": 600, "image_width": 800,
        }  # fmt: skip
        await self._socket.send(msgspec.msgpack.encode(camera))

    async def until(self, name: str, is_so: Any = lambda node: True) -> dict[str, Any]:
        """Wait for a node to be as wanted."""
        async with asyncio.timeout(10):
            while name not in self.nodes or not is_so(self.nodes[name]):
                self._take(bytes(await self._socket.recv()))  # type: ignore[arg-type]
        return self.nodes[name]

    def _take(self, frame: bytes) -> None:
        size, packed = int.from_bytes(frame[:8], "little"), int.from_bytes(frame[8:16], "little")
        data = zstandard.ZstdDecompressor().decompress(frame[16 : 16 + packed], max_output_size=size)
        for message in msgspec.msgpack.decode(data)["messages"]:
            name, kind = message.get("name"), message["type"]
            if name is None:
                continue
            key = f"{message.get('owner', '')}:{name}" if message.get("owner") else name
            if kind == "RemoveSceneNodeMessage":
                self.nodes.pop(key, None)
            elif kind in ("SetPositionMessage", "SetOrientationMessage", "SetSceneNodeVisibilityMessage"):
                self.nodes.setdefault(key, {}).update(message)
            else:
                self.nodes[key] = {**self.nodes.get(key, {}), **message}


async def connect(studio: Studio, key: str, secret: str = SECRET) -> websockets.asyncio.client.ClientConnection:
    """Open a picture as the console does."""
    return await websockets.asyncio.client.connect(
        f"ws://127.0.0.1:{studio.viser_port}/",
        additional_headers={SECRET_HEADER: secret, VIEWER_HEADER: key},
        subprotocols=[Subprotocol("viser-v1.1.1")],
        max_size=64 * 2**20,
        compression=None,
        proxy=None,
    )
