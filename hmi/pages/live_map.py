"""Where the live map goes on a screen."""

from __future__ import annotations

from components.live_element import LiveElement


def place(robot_id: str) -> None:
    """Put the map of one robot here."""
    LiveElement("hl-map-place", classes="h-mapfill", hook="map", data_robot=robot_id)
