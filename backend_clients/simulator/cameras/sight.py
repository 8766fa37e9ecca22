"""What was found in the newest picture of a camera that somebody pulls."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from backend_clients.edge import machine as edge
from backend_clients.simulator.cameras.scene import Box

FRESH_S = 1.0


@dataclass(frozen=True, slots=True)
class Sight:
    """Boxes of one picture; ``taken_s`` on the simulator's monotonic clock, ``captured_ms`` the robot's wall clock."""

    camera: str
    taken_s: float
    captured_ms: int
    boxes: list[Box] = field(default_factory=list)

    def is_fresh(self, now_s: float) -> bool:
        """Say whether the picture is so new that somebody still pulls them."""
        return now_s - self.taken_s < FRESH_S

    def fields(self) -> dict[str, Any]:
        """Return the edge message without its header."""
        boxes = [
            edge.Box(
                kind=one.kind,
                x=_share(one.x),
                y=_share(one.y),
                w=_share(one.w),
                h=_share(one.h),
                score=_share(one.score),
                hit=one.hit,
            )
            for one in self.boxes[: edge.MAX_BOXES]
        ]
        return {"camera": self.camera, "captured_ms": self.captured_ms, "boxes": boxes}


def _share(value: float) -> float:
    return min(max(value, 0.0), 1.0)
