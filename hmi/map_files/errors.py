"""What goes wrong with a map file; the tree is in ``hmi.domain.refused_file``."""

from __future__ import annotations

from hmi.domain.refused_file import RefusedFile


class BadMapFile(RefusedFile):
    """The file, or the wish to write one, is refused as a whole."""
