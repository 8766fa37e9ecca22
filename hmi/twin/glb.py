"""Coloured triangles as binary glTF 2.0 (Khronos, section 4.4): one mesh, one matt material, nothing outside."""

from __future__ import annotations

import json
import struct

import numpy as np
from numpy.typing import NDArray

from hmi.twin.solids import Floats

_FLOAT, _BYTE = 5126, 5121
GHOST_ALPHA = 0.34


def glb_of(corners: Floats, colours: NDArray[np.uint8], *, alpha: float = 1.0) -> bytes:
    """Return a GLB.

    Args:
        corners: (3N, 3) metres, three to a triangle.
        colours: (3N, 3) sRGB.
        alpha: below 1 it is see-through.
    """
    count = len(corners)
    rgba = np.concatenate([_linear(colours), np.full((count, 1), 255, np.uint8)], axis=1)
    parts = [np.ascontiguousarray(corners, np.float32).tobytes(), _normals(corners).tobytes(), rgba.tobytes()]
    body = b"".join(parts)
    material = {
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, alpha], "metallicFactor": 0.0, "roughnessFactor": 0.85},
        "doubleSided": True,
    }
    if alpha < 1:
        material["alphaMode"] = "BLEND"
    head = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "COLOR_0": 2}, "material": 0}]}],
        "materials": [material],
        "accessors": [
            {"bufferView": 0, "componentType": _FLOAT, "count": count, "type": "VEC3",
             "min": corners.min(axis=0).tolist(), "max": corners.max(axis=0).tolist()},
            {"bufferView": 1, "componentType": _FLOAT, "count": count, "type": "VEC3"},
            {"bufferView": 2, "componentType": _BYTE, "normalized": True, "count": count, "type": "VEC4"},
        ],
        "bufferViews": _views([len(part) for part in parts]),
        "buffers": [{"byteLength": len(body)}],
    }  # fmt: skip
    return _file(json.dumps(head, separators=(",", ":")).encode(), body)


def _views(sizes: list[int]) -> list[dict[str, int]]:
    starts = np.cumsum([0, *sizes[:-1]]).tolist()
    return [{"buffer": 0, "byteOffset": start, "byteLength": size} for start, size in zip(starts, sizes, strict=True)]


def _file(head: bytes, body: bytes) -> bytes:
    head += b" " * (-len(head) % 4)
    body += b"\0" * (-len(body) % 4)
    chunks = struct.pack("<I4s", len(head), b"JSON") + head + struct.pack("<I4s", len(body), b"BIN\0") + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _normals(corners: Floats) -> Floats:
    a, b, c = corners[0::3], corners[1::3], corners[2::3]
    found = np.cross(b - a, c - a)
    length = np.linalg.norm(found, axis=1, keepdims=True)
    unit = np.divide(found, length, out=np.tile([0.0, 0.0, 1.0], (len(a), 1)).astype(found.dtype), where=length > 1e-12)
    return np.repeat(unit, 3, axis=0).astype(np.float32)


def _linear(colours: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Vertex colours of glTF are linear light."""
    share = colours.astype(np.float64) / 255
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.round(light * 255), dtype=np.uint8)
