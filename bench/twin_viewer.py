"""A viewer for the twin's bench: says where it looks from, takes everything, keeps nothing."""

from __future__ import annotations

import msgspec
from websockets.asyncio.client import ClientConnection

CAMERA = msgspec.msgpack.encode(
    {
        "type": "ViewerCameraMessage",
        "wxyz": (1.0, 0.0, 0.0, 0.0),
        "position": (3.0, 3.0, 3.0),
        "fov": 1.0,
        "near": 0.01,
        "far": 1000.0,
        "look_at": (0.0, 0.0, 0.0),
        "up_direction": (0.0, 0.0, 1.0),
        "image_height": 600,
        "image_width": 800,
    }
)


async def drain(socket: ClientConnection) -> None:
    """Take frames until cancelled."""
    async for _ in socket:
        pass
