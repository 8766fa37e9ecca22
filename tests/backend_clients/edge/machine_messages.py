"""Messages about the inside of a machine, with everything in them."""

from __future__ import annotations

from typing import Any

from backend_clients.edge import machine


def body(**values: Any) -> machine.Body:
    """Return a crane on its way to a tree, a person near."""
    return machine.Body(
        joints={"slew": -0.52, "boom": 0.5},
        planned={"slew": -0.6, "boom": 0.4},
        gauges={"pressure": 164.0},
        tool=(4.0, -2.5, 0.22),
        is_loaded=True,
        stock=41,
        seen=[machine.Sighting(id="p1", kind="person", x_m=9.0, y_m=1.0, distance_m=7.4)],
        **values,
    )


def worksite(**values: Any) -> machine.Worksite:
    """Return a site with a stump, a tree that stands and one that failed."""
    return machine.Worksite(
        stop=3,
        area=[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)],
        obstacles=[machine.Obstacle(id="o1", kind="stump", x_m=1.0, y_m=2.0, radius_m=0.2, height_m=0.4)],
        targets=[
            machine.Target(id="t146", x_m=2.0, y_m=2.0, status="done"),
            machine.Target(id="t147", x_m=3.0, y_m=2.0, status="failed_ground", text="No ground contact"),
        ],
        **values,
    )


def detections(**values: Any) -> machine.Detections:
    """Return what was found in a picture."""
    weed = machine.Box(kind="weed", x=0.4, y=0.6, w=0.05, h=0.04, score=0.9, hit=True)
    return machine.Detections(**{"camera": "front", "captured_ms": 1_790_000_000_000, "boxes": [weed], **values})


def scan(**values: Any) -> machine.Scan:
    """Return a cloud of one point."""
    return machine.Scan(origin=(1.0, 2.0, 0.0), points="AQACAAMA", **values)
