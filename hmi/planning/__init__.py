"""Coverage planning; pure, on shapely and pyproj."""
