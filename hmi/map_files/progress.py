"""How far a file is read."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Progress(NamedTuple):
    """The share that is done, 0 to 1, and the shapes found so far."""

    share: float
    shapes: int = 0


Report = Callable[[Progress], None]
