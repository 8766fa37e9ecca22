"""Where a robot is and how it stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from hmi.twin.kinematics import Place


@dataclass(frozen=True, slots=True)
class Posture:
    """Body in the site's plane and joints as measured; ``planned`` holds the joints it is on its way to.

    ``at_s`` is when the body stood there, on this process's monotonic clock; ``None`` where that cannot be said, for
    the declared joints of ``unheard`` were not heard and are drawn at rest.
    """

    body: Place
    joints: Mapping[str, float] = field(default_factory=dict)
    planned: Mapping[str, float] = field(default_factory=dict)
    at_s: float | None = 0.0
    unheard: tuple[str, ...] = ()
