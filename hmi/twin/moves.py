"""viser's two messages that move a frame, in plain values: it sends them as they are.

viser looks at each value of each message again, by its type hints and for every viewer; with fifty machines that was
more than half of what a picture cost.
"""

from __future__ import annotations

from typing import Any

from viser import _messages

from hmi.twin.model import Quaternion, Vector


class Position(_messages.SetPositionMessage):
    """Puts a frame somewhere; ``position`` has Python's own floats."""

    def __init__(self, name: str, position: Vector) -> None:
        self.name, self.position = name, position
        self._cached_redundancy_key = f"scene:{name}:update:SetPositionMessage"

    def as_serializable_dict(self, binary_buffers: list[memoryview] | None = None) -> dict[str, Any]:
        """Return what is sent."""
        return {"name": self.name, "position": self.position, "owner": self.owner, "type": "SetPositionMessage"}


class Orientation(_messages.SetOrientationMessage):
    """Turns a frame; ``wxyz`` has Python's own floats."""

    def __init__(self, name: str, wxyz: Quaternion) -> None:
        self.name, self.wxyz = name, wxyz
        self._cached_redundancy_key = f"scene:{name}:update:SetOrientationMessage"

    def as_serializable_dict(self, binary_buffers: list[memoryview] | None = None) -> dict[str, Any]:
        """Return what is sent."""
        return {"name": self.name, "wxyz": self.wxyz, "owner": self.owner, "type": "SetOrientationMessage"}
