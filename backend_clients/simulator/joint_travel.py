"""Where a joint may be, and how it moves by hand."""

from __future__ import annotations

from backend_clients.edge.machine import Joint

REACHED = 1e-6
SLOW_SHARE = 0.25  # of its speed, beyond a soft limit


def is_beyond(joint: Joint, value: float) -> bool:
    """Say whether a joint is outside its soft limits."""
    low = joint.soft_lower is not None and value < joint.soft_lower - REACHED
    return low or (joint.soft_upper is not None and value > joint.soft_upper + REACHED)


def travel_share(joint: Joint, value: float) -> float:
    """Return how far a joint is from its lower limit to its upper one, 0 to 1."""
    return (value - joint.lower) / (joint.upper - joint.lower)


def moved_by_hand(joint: Joint, at: float, rate: float, dt_s: float) -> float:
    """Return where a joint is after ``dt_s``: a soft limit slows what goes further out, a limit stops it."""
    v = min(max(rate, -joint.max_rate), joint.max_rate)
    if _is_going_out(joint, at, v):
        v *= SLOW_SHARE
    return min(max(at + v * dt_s, joint.lower), joint.upper)


def _is_going_out(joint: Joint, at: float, v: float) -> bool:
    low = joint.soft_lower is not None and v < 0 and at <= joint.soft_lower
    return low or (joint.soft_upper is not None and v > 0 and at >= joint.soft_upper)
