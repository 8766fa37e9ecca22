"""Coverage planning on a local plane: pure functions over shapely geometry, metres and radians."""
