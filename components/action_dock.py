"""What can be asked of the robot now: buttons, slides, and why something is off."""

from __future__ import annotations

from components.live_element import LiveElement


class ActionDock(LiveElement):
    """Actions by state of the robot; each refused one keeps its place and says why."""

    def __init__(self) -> None:
        super().__init__(
            "hl-actions", hook="actions", classes="h-dockbar h-actions", aria_label="Actions", role="group"
        )
