"""A small farm that operations are tried on, and how a refusal looks."""

from __future__ import annotations

from typing import Any

import pytest

from hmi.mapping.errors import OperationRefused
from hmi.mapping.feature import MapFeature
from hmi.mapping.operations import apply
from tests.hmi.mapping.farms import area, box, draft, line

NORTH = area("nordfeld-12", box(0, 0, 100, 60), name="Nordfeld 12", crop="Wheat", row_bearing_deg=11.5)
EAST = area("east", box(100, 0, 150, 60), name="East")
HOLED = area("holed", box(0, 0, 100, 60), box(40, 20, 60, 40)[::-1], name="Holed")
BOW = area("bow", [(0, 0), (60, 0), (0, 60), (60, 60), (0, 0)], name="Bow")
LANE = line("lane", [(-50, -2), (0, -2), (120, -2)], name="Lane", width_m=4)
FARM = draft(NORTH, EAST, LANE)


def refused(op: str, features: dict[str, MapFeature], ids: list[str], **args: Any) -> OperationRefused:
    """Return why an operation is refused."""
    with pytest.raises(OperationRefused) as caught:
        apply(op, features, ids, args)
    assert caught.value.text.endswith(".")
    return caught.value


def label(op: str, features: dict[str, MapFeature], ids: list[str], **args: Any) -> str:
    """Return how an operation reads in the log."""
    return apply(op, features, ids, args).label
