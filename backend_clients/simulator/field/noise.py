"""Smooth noise that is a function of seed and time: the same moment always has the same weather."""

from __future__ import annotations

from functools import lru_cache

_MASK = (1 << 64) - 1


def chance(seed: int, stream: int, cell: int) -> float:
    """Return a number from 0 to 1 for a cell of a stream (splitmix64's last steps)."""
    x = (seed * 0x9E3779B97F4A7C15 + stream * 0xC2B2AE3D27D4EB4F + cell * 0x165667B19E3779F9) & _MASK
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & _MASK
    return ((x ^ (x >> 31)) >> 11) / (1 << 53)


_kept_chance = lru_cache(maxsize=4096)(chance)  # neighbouring moments share their cells


def smooth(seed: int, stream: int, at_s: float, cell_s: float) -> float:
    """Return noise from -1 to 1 that changes over ``cell_s`` seconds, without steps or corners."""
    place = at_s / cell_s
    cell = int(place // 1)
    share = place - cell
    share = share * share * (3 - 2 * share)
    low, high = _kept_chance(seed, stream, cell), _kept_chance(seed, stream, cell + 1)
    return 2 * (low + (high - low) * share) - 1
