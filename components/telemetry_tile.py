"""One number with its age, its normal band and one line of meaning."""

from __future__ import annotations

from components.live_element import LiveElement


class TelemetryTile(LiveElement):
    """A tile of the robot on screen; hook ``value-{key}``, SI in ``data-value``, age in ``data-age-ms``.

    Args:
        key: key of the tile in the lane's ``tiles`` group.
        label: what it is called until the robot says so.
    """

    def __init__(self, key: str, label: str) -> None:
        super().__init__("hl-tile", classes="h-tile", hook=f"value-{key}", data_key=key, data_label=label)
