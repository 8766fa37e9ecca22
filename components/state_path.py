"""The active states of the robot's supervisor, outermost first, with the time in the innermost."""

from __future__ import annotations

from components.live_element import LiveElement


class StatePath(LiveElement):
    """Hook ``supervisor-path``; the path joined by `` > `` in ``data-value``."""

    def __init__(self) -> None:
        super().__init__("hl-state-path", classes="h-card", hook="supervisor-path")
