"""Manual driving: the machine moves only while a pad, key or stick is held."""

from __future__ import annotations

from components.live_element import LiveElement


class HoldToDrive(LiveElement):
    """Pads over the map, shown while this browser drives; hooks ``drive-forward``, ``-left``, ``-right``, ``-back``."""

    def __init__(self) -> None:
        super().__init__("hl-drive", hook="drive", classes="h-drive", hidden="")
