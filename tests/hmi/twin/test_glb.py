"""What is drawn of a link: its triangles, with corners shared that are alike in place and colour."""

from __future__ import annotations

import json
import struct

import numpy as np

from hmi.twin.glb import glb_of


def test_corners_are_shared_only_where_place_and_colour_are_the_same() -> None:
    corners = np.asarray([(0, 0, 0), (1, 0, 0), (0, 1, 0), (-0.0, 0, 0), (0, 1, 0), (0, 0, 1)], np.float32)
    colours = np.asarray([(9, 9, 9)] * 4 + [(200, 9, 9), (9, 9, 9)], np.uint8)
    points, tints, order = parts(glb_of(corners, colours))
    assert len(points) == 5, "the first corner twice, the third one in two colours"
    np.testing.assert_array_equal(points[order], corners)
    assert len({tuple(tints[one]) for one in order[:4]}) == 1
    assert tuple(tints[order[4]]) != tuple(tints[order[2]])


def parts(glb: bytes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    """Return places, colours and indices."""
    size = struct.unpack("<I", glb[12:16])[0]
    head, body = json.loads(glb[20 : 20 + size]), glb[28 + size :]
    views = [body[one["byteOffset"] :][: one["byteLength"]] for one in head["bufferViews"]]
    kinds = [(np.float32, 3), (np.uint8, 4), (np.uint32, 1)]
    found = [np.frombuffer(view, kind).reshape(-1, wide) for view, (kind, wide) in zip(views, kinds, strict=True)]  # type: ignore[call-overload]
    return found[0], found[1], found[2].reshape(-1)
