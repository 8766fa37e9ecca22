"""Coloured triangles as binary glTF 2.0 (Khronos, section 4.4): one mesh, one matt material, nothing outside."""

from __future__ import annotations

import json
import struct

import numpy as np
from numpy.typing import NDArray

from hmi.twin.solids import Floats

_FLOAT, _BYTE, _INDEX = 5126, 5121, 5125
GHOST_ALPHA = 0.34
SHADE, SHADE_ALPHA = (0.22, 0.24, 0.25), 0.45  # linear light


def glb_of(corners: Floats, colours: NDArray[np.uint8], *, alpha: float = 1.0) -> bytes:
    """Return a GLB. Without normals it is drawn flat (section 3.7.2.1), and corners of one colour are shared.

    Args:
        corners: (3N, 3) metres, three to a triangle.
        colours: (3N, 3) sRGB.
        alpha: below 1 it is see-through.
    """
    points, tints, order = _shared(corners, colours)
    rgba = np.concatenate([_linear(tints), np.full((len(tints), 1), 255, np.uint8)], axis=1)
    parts = [points.tobytes(), rgba.tobytes(), order.tobytes()]
    body = b"".join(parts)
    material: dict[str, object] = {
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, alpha], "metallicFactor": 0.0, "roughnessFactor": 0.85},
        "doubleSided": True,
    }
    if alpha < 1:
        material["alphaMode"] = "BLEND"
    primitive = {"attributes": {"POSITION": 0, "COLOR_0": 1}, "indices": 2, "material": 0}
    head = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive]}],
        "materials": [material],
        "accessors": [
            {"bufferView": 0, "componentType": _FLOAT, "count": len(points), "type": "VEC3",
             "min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()},
            {"bufferView": 1, "componentType": _BYTE, "normalized": True, "count": len(points), "type": "VEC4"},
            {"bufferView": 2, "componentType": _INDEX, "count": len(order), "type": "SCALAR"},
        ],
        "bufferViews": _views([len(part) for part in parts]),
        "buffers": [{"byteLength": len(body)}],
    }  # fmt: skip
    return _file(json.dumps(head, separators=(",", ":")).encode(), body)


def shade_of(glb: bytes) -> bytes:
    """Return a GLB made here as a see-through grey shade of itself: nothing of its own colours is left."""
    size = int.from_bytes(glb[12:16], "little")
    head = json.loads(glb[20 : 20 + size])
    for mesh in head["meshes"]:
        for primitive in mesh["primitives"]:
            del primitive["attributes"]["COLOR_0"]
    head["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = [*SHADE, SHADE_ALPHA]
    head["materials"][0]["alphaMode"] = "BLEND"
    return _file(json.dumps(head, separators=(",", ":")).encode(), glb[20 + size + 8 :])


def _shared(corners: Floats, colours: NDArray[np.uint8]) -> tuple[Floats, NDArray[np.uint8], NDArray[np.uint32]]:
    """Return every place of a colour once, and which of them each corner is.

    Rows are compared as whole numbers: ``np.unique`` takes seven times as long over rows, and no other thread runs
    meanwhile.
    """
    points = np.ascontiguousarray(np.round(corners, 5), np.float32) + np.float32(0)  # minus zero has other bits
    rows = np.zeros((len(points), 4), np.uint32)
    rows[:, :3] = points.view(np.uint32)
    rows.view(np.uint8)[:, 12:15] = colours
    keys = rows.view(np.uint64)
    by_key = np.lexsort((keys[:, 0], keys[:, 1]))
    alike = keys[by_key]
    is_first = np.ones(len(alike), np.bool_)
    is_first[1:] = (alike[1:] != alike[:-1]).any(axis=1)
    order = np.empty(len(alike), np.uint32)
    order[by_key] = np.cumsum(is_first, dtype=np.uint32) - np.uint32(1)
    unique = by_key[is_first]
    return points[unique], colours[unique], order


def _views(sizes: list[int]) -> list[dict[str, int]]:
    starts = np.cumsum([0, *sizes[:-1]]).tolist()
    return [{"buffer": 0, "byteOffset": start, "byteLength": size} for start, size in zip(starts, sizes, strict=True)]


def _file(head: bytes, body: bytes) -> bytes:
    head += b" " * (-len(head) % 4)
    body += b"\0" * (-len(body) % 4)
    chunks = struct.pack("<I4s", len(head), b"JSON") + head + struct.pack("<I4s", len(body), b"BIN\0") + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _linear(colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Vertex colours of glTF are linear light."""
    share = colours.astype(np.float64) / 255
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.round(light * 255), dtype=np.uint8)
