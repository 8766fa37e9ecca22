"""The scene's layers: each hangs below one frame, so that a viewer can hide it without disturbing anybody."""

from __future__ import annotations

from enum import StrEnum


class Group(StrEnum):
    """Layers by the name of their frame; people see the words of the page."""

    MACHINE = "machine"
    PLANNED = "planned"
    TREES = "trees"
    SCAN = "scan"
    LIMITS = "limits"
    KEEPOUT = "keepout"
    REACH = "reach"
    PATH = "path"
    TRAIL = "trail"
    OBSTACLES = "obstacles"
    CAMERAS = "cameras"
    LABELS = "labels"
    PARCEL = "parcel"
    TERRAIN = "terrain"

    def of(self, robot_id: str) -> str:
        """Return the frame of one robot in this layer."""
        return f"/{self.value}/{robot_id}"

    @property
    def frame(self) -> str:
        """The frame of the whole layer."""
        return f"/{self.value}"


HIDDEN_AT_FIRST = frozenset({Group.TERRAIN, Group.CAMERAS})
