"""What goes wrong with a base map; the tree is in ``hmi.domain.refused_file``."""

from __future__ import annotations

from hmi.domain.refused_file import RefusedFile


class BadBaseMap(RefusedFile):
    """The file is refused as a whole, or cannot be used any more."""
