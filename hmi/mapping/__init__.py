"""The farm map as values: features, what can be done to them, what is wrong with them, what changed.

Pure functions: nothing here reads a clock, a file or a wire. Positions come and go as WGS84 ``[longitude, latitude]``
degrees; lengths and areas are worked out in metres on a plane beside the features (``hmi.mapping.ground``).
"""
