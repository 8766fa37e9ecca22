"""Where a robot is and how it stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hmi.domain.freshness import STALE_S
from hmi.twin.doubt import EVERYTHING, NOTHING, Doubt
from hmi.twin.kinematics import Place


@dataclass(frozen=True, slots=True)
class Posture:
    """Body in the site's plane and joints as measured; ``planned`` holds the joints it is on its way to.

    ``at_s`` is when the whole of it was true, on this process's monotonic clock; ``None`` where that cannot be said,
    for the declared joints of ``unheard`` were not heard and are drawn at rest. ``body_at_s`` is when the body stood
    there, ``joints_at_s`` when the ``declared`` joints stood so, by the same clock.
    """

    body: Place
    joints: Mapping[str, float] = field(default_factory=dict)
    planned: Mapping[str, float] = field(default_factory=dict)
    at_s: float | None = 0.0
    unheard: tuple[str, ...] = ()
    body_at_s: float | None = None
    joints_at_s: float | None = None
    declared: tuple[str, ...] = ()

    def doubt(self, now_s: float) -> Doubt:
        """Return what of it is not known to be so now."""
        if self.body_at_s is not None and now_s - self.body_at_s > STALE_S:
            return EVERYTHING
        if self.joints_at_s is not None and now_s - self.joints_at_s > STALE_S:
            return Doubt(joints=frozenset(self.declared))
        return Doubt(joints=frozenset(self.unheard)) if self.unheard else NOTHING
