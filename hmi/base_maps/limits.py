"""How much a base map may hold, and how much work one may make."""

from __future__ import annotations

DIRECTORY_BYTES = 4_000_000  # one unpacked directory; writers keep them under 100 KB
DIRECTORY_ENTRIES = 100_000
DIRECTORIES_DEEP = 3  # the format asks for two at most
METADATA_BYTES = 2_000_000
TILE_BYTES = 5_000_000
MOST_ZOOM = 24

PIXELS = 4_000_000_000  # 160 ha at 2 cm; more pixels than a screen can tell apart at any zoom
SIDE_PIXELS = 400_000
BLOCK_BYTES = 256_000_000  # what one read must unpack at once
NEAREST_ZOOM = 22  # 1.9 cm a pixel at the equator, 512 px tiles
TILES = 120_000  # the 160 ha above take 20,000

MEMORY_BYTES = 3 * 1024**3  # address space of the process; GDAL and numpy alone reserve a third of it
CONVERT_LIMIT_S = 5400.0  # a photo of 4,000 million pixels on one slow core
INSPECT_LIMIT_S = 60.0
NAME_CHARS = 80
CREDIT_CHARS = 160
