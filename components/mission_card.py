"""The mission of the robot on screen: row of rows, one tick per row, area, when done, time left."""

from __future__ import annotations

from components.live_element import LiveElement


class MissionCard(LiveElement):
    """Hooks ``value-row``, ``value-area`` and ``value-eta`` inside."""

    def __init__(self, *, has_mission: bool = False) -> None:
        super().__init__("hl-mission", classes="h-card h-mission", hook="mission-card")
        if has_mission:  # its room is kept until the first values come: nothing below may jump then
            self._props["data-awaited"] = ""
