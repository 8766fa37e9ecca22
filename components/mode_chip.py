"""Who moves the machine: AUTO, MANUAL, PAUSED, STOPPED, NOT CONFIRMED."""

from __future__ import annotations

from components.live_element import LiveElement


class ModeChip(LiveElement):
    """Hook ``robot-mode``; state and look follow the robot, its link and the STOP gateway."""

    def __init__(self) -> None:
        super().__init__("hl-mode", hook="robot-mode", data_state="unknown")
