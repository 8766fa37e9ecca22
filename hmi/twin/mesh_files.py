"""Meshes of an uploaded model: only from its own folder, only the four formats, nothing fetched.

What a stranger made is parsed by ``trimesh``; callers do that in a process of its own.
"""

from __future__ import annotations

import codecs
import io
import json
import re
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import trimesh
from numpy.typing import NDArray

from hmi.twin.errors import ModelError, UnsafeModel
from hmi.twin.limits import MAX_FACES, MAX_MESH_BYTES, MAX_SIZE_M
from hmi.twin.model import Box, MeshFile
from hmi.twin.solids import Floats, triangles_of

KINDS = {".stl": "stl", ".obj": "obj", ".dae": "dae", ".glb": "glb"}
STAND_IN = Box((0.3, 0.3, 0.3))  # metres; drawn where a mesh is missing
STAND_IN_COLOUR = (214, 120, 30)
_SCHEME = re.compile(r"[a-zA-Z][a-zA-Z0-9+.-]*:")
_DECLARES = re.compile(rb"<!(DOCTYPE|ENTITY)", re.IGNORECASE)
_ENCODING = re.compile(rb"<\?xml[^>]*?\bencoding\s*=\s*[\"']([^\"']*)")
_PLAIN = (b"utf-8", b"us-ascii", b"ascii", b"iso-8859-1", b"windows-1252")  # ASCII is itself in all of them
_PACKED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_texture_basisu")


class MeshFolder:
    """The files of one model; ``notices`` says which meshes were missing."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder.resolve()
        self.notices: list[str] = []

    def read(self, mesh: MeshFile, link: str) -> tuple[Floats, NDArray[np.uint8] | None]:
        """Return corners and colours of a mesh; a box stands in for one that is missing.

        Raises:
            UnsafeModel: it lies outside, is too large, or refers to something else.
            ModelError: it is broken or of another format.
        """
        where = f'Link "{link}"'
        path = self._find(mesh.name, where)
        if path is None:
            self.notices.append(f'{where}: there is no "{mesh.name[:80]}" in the upload. A box stands in for it.')
            return _stand_in(mesh)
        kind = KINDS.get(path.suffix.lower())
        if kind is None:
            raise ModelError(f'{where}: "{path.name}" is no STL, OBJ, DAE or GLB.')
        if path.stat().st_size > MAX_MESH_BYTES:
            raise UnsafeModel(f'{where}: "{path.name}" is over {MAX_MESH_BYTES // 2**20} MB. Simplify it.')
        data = path.read_bytes()
        _check(kind, data, where, path.name)
        corners, colours = _parsed(kind, data, where, path.name)
        if len(corners) > 0:
            return corners, colours
        if kind != "dae":  # what its materials refer to may be missing, and then none of its shapes is found
            raise ModelError(f'{where}: "{path.name}" holds no triangles.')
        self.notices.append(f'{where}: no triangles were found in "{path.name}". A box stands in for it.')
        return _stand_in(mesh)

    def _find(self, name: str, where: str) -> Path | None:
        text = plain_name(name)
        if text.startswith("package://"):
            text = text.removeprefix("package://").lstrip("/")  # some tools write three slashes
            choices = [text, *_endings(text)]  # a ROS package is uploaded with its folder or without
        elif _SCHEME.match(text) or text.startswith("/"):
            raise UnsafeModel(f'{where}: "{name[:80]}" is not a file of the upload. Name it relative to the URDF.')
        else:
            choices = [text]
        for choice in choices:
            if "\0" in choice or not (path := (self._folder / choice).resolve()).is_relative_to(self._folder):
                raise UnsafeModel(f'{where}: "{name[:80]}" lies outside the upload. It is refused.')
            if choice and is_file(path):
                return path
        return self._only_one(choices) if len(choices) > 1 else None

    def _only_one(self, endings: list[str]) -> Path | None:
        """Find a package's file wherever its folder lies in the upload, if no other file ends alike."""
        files = [path for path in self._folder.rglob("*") if path.is_file()]
        for ending in endings:
            found = [path for path in files if f"/{path.relative_to(self._folder).as_posix()}".endswith(f"/{ending}")]
            if found:
                return found[0] if len(found) == 1 else None
        return None


def plain_name(name: str) -> str:
    """Return a mesh's name as a path: escapes read, slashes forward."""
    return unquote(name).replace("\\", "/").strip()


def is_file(path: Path) -> bool:
    """Whether a file is there; a name longer than any file's may be is none."""
    try:
        return path.is_file()
    except OSError:
        return False


def _endings(text: str) -> list[str]:
    """Return a path without its first folder, without its first two, and so on."""
    parts = text.split("/")
    return ["/".join(parts[at:]) for at in range(1, len(parts))]


def _stand_in(mesh: MeshFile) -> tuple[Floats, NDArray[np.uint8]]:
    corners = np.asarray(triangles_of(STAND_IN) / np.maximum(np.abs(mesh.scale), 1e-6), dtype=np.float32)
    return corners, np.tile(np.asarray(STAND_IN_COLOUR, np.uint8), (len(corners), 1))


def _check(kind: str, data: bytes, where: str, name: str) -> None:
    """Refuse what a parser might follow or choke on, before it sees it."""
    if kind == "dae" and not _is_readable(data):
        raise UnsafeModel(f'{where}: "{name}" is not written in UTF-8. Save it in UTF-8.')
    if kind == "dae" and _DECLARES.search(data):
        raise UnsafeModel(f'{where}: "{name}" declares a document type or entities. It is refused.')
    if kind == "glb":
        _check_glb(data, where, name)
    if kind == "obj" and data.count(b"\nf ") > MAX_FACES:
        raise UnsafeModel(f'{where}: "{name}" has over {MAX_FACES} faces. Simplify it.')
    if kind == "stl" and len(data) >= 84 and data[:5].lower() != b"solid":
        count = struct.unpack_from("<I", data, 80)[0]
        if count > MAX_FACES or 84 + 50 * count > len(data) + 1024:
            raise UnsafeModel(f'{where}: "{name}" claims {count} faces, at most {MAX_FACES} are drawn.')


def _is_readable(xml: bytes) -> bool:
    """Whether the bytes that are searched are the ones a parser reads: other encodings hide what they declare."""
    declared = _ENCODING.match(xml.removeprefix(codecs.BOM_UTF8))
    return b"\0" not in xml and (declared is None or declared[1].lower() in _PLAIN)


def _check_glb(data: bytes, where: str, name: str) -> None:
    try:
        magic, _version, _length, size, mark = struct.unpack_from("<4sIII4s", data)
        head = json.loads(data[20 : 20 + size])
    except (struct.error, ValueError) as error:
        raise ModelError(f'{where}: "{name}" is no binary glTF.') from error
    if magic != b"glTF" or mark != b"JSON" or not isinstance(head, dict):
        raise ModelError(f'{where}: "{name}" is no binary glTF.')
    used = {*head.get("extensionsUsed", ()), *head.get("extensionsRequired", ())}
    if packed := used.intersection(_PACKED):
        raise UnsafeModel(f'{where}: "{name}" is packed with {min(packed)}. Export it without compression.')
    for entry in [*head.get("buffers", ()), *head.get("images", ())]:
        if isinstance(entry, dict) and "uri" in entry and not str(entry["uri"]).startswith("data:"):
            raise UnsafeModel(f'{where}: "{name}" refers to another file. Export it as one GLB.')


def _parsed(kind: str, data: bytes, where: str, name: str) -> tuple[Floats, NDArray[np.uint8] | None]:
    try:
        found = trimesh.load_scene(io.BytesIO(data), file_type=kind, skip_materials=kind == "obj")
        mesh = found.to_mesh()
        corners = np.asarray(mesh.triangles, dtype=np.float32).reshape(-1, 3)
        colours = _colours(mesh)
    except Exception as error:
        raise ModelError(f'{where}: "{name}" cannot be read ({type(error).__name__}). Export it once more.') from error
    if len(corners) > 3 * MAX_FACES:
        raise UnsafeModel(f'{where}: "{name}" has over {MAX_FACES} triangles. Simplify it.')
    if not np.isfinite(corners).all():
        raise ModelError(f'{where}: "{name}" has corners that are not finite numbers.')
    return corners, colours


def _colours(mesh: trimesh.Trimesh) -> NDArray[np.uint8] | None:
    visual: Any = mesh.visual
    if visual is None or visual.kind not in ("face", "vertex", "texture"):
        return None
    if visual.kind == "texture":  # pictures are left out: the colour of the material stands for them
        tint = np.asarray(visual.material.main_color, np.uint8)[:3]
        return np.tile(tint, (3 * len(mesh.faces), 1))
    return np.repeat(np.asarray(visual.face_colors, np.uint8)[:, :3], 3, axis=0)


def check_extent(corners: Floats, what: str) -> None:
    """Raise ``ModelError`` for a model that no field could hold."""
    size = float(np.abs(corners).max(initial=0.0))
    if size > MAX_SIZE_M:
        raise ModelError(f"{what} is {size:.0f} m large. Is it in millimetres? Give the mesh scale 0.001.")
