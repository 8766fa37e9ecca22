"""How much a map file may hold. A farm of 1,000 fields stays far below all of it;
the export of a whole district, of which a farm takes its own, is just within it."""

from __future__ import annotations

from hmi.map_files.errors import BadMapFile

FILE_BYTES = 50_000_000
UNPACKED_BYTES = 200_000_000  # all entries of an archive together
ENTRIES = 2_000
RATIO = 200  # unpacked to packed; map data stays below 50
RATIO_FROM_BYTES = 1_000_000  # a small table of blanks may pack better than that and does no harm
VERTICES = 1_000_000
FEATURES = 20_000
TEXT_CHARS = 500  # of one attribute
ATTRIBUTES = 200  # of one feature
OWN_CHARS = 32_768  # of one attribute in a file of this program: what a feature of the map may hold
OWN_ATTRIBUTES = 5_000
NAME_CHARS = 200
KEY_CHARS = 64
DEPTH = 4  # collections within collections


class Allowance:
    """Counts what a file has used up of the limits."""

    def __init__(self) -> None:
        self._features = 0
        self._vertices = 0

    def feature(self) -> None:
        """Count one feature.

        Raises:
            BadMapFile: ``too_many_features``.
        """
        self._features += 1
        if self._features > FEATURES:
            text = f"The file has more than {FEATURES:,} shapes. Split it, or export only this farm."
            raise BadMapFile("too_many_features", text)

    def vertices(self, n: int) -> None:
        """Count ``n`` corners.

        Raises:
            BadMapFile: ``too_many_vertices``.
        """
        self._vertices += n
        if self._vertices > VERTICES:
            text = f"The file has more than {VERTICES:,} corners. Simplify the shapes or split the file."
            raise BadMapFile("too_many_vertices", text)
