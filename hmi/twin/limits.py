"""How large a robot model may be."""

from __future__ import annotations

MAX_ZIP_BYTES = 40 * 1024 * 1024
MAX_UNPACKED_BYTES = 120 * 1024 * 1024
MAX_FILES = 400
MAX_URDF_BYTES = 2 * 1024 * 1024
MAX_MESH_BYTES = 24 * 1024 * 1024
MAX_LINKS = 200
MAX_VISUALS = 400
MAX_DEPTH = 60  # elements within elements of the XML; a URDF has five
MAX_FACES = 300_000  # of all meshes together: what a tablet draws at 20 frames a second
MAX_SIZE_M = 200.0  # no machine is larger; a model in millimetres is found by this
READ_LIMIT_S = 60.0
CHUNK_LIMIT_S = 20.0  # between two pieces of an upload
STALLED = f"Nothing of the upload came for {CHUNK_LIMIT_S:.0f} s. Upload it once more."
READ_MEMORY_BYTES = 3 * 1024**3
