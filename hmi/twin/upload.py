"""An uploaded model: unpacked into a folder of its own, read once, kept as plain arrays.

``read_upload`` is meant for a process of its own with bounded memory: it parses what a stranger made.
"""

from __future__ import annotations

import errno
import io
import json
import lzma
import shutil
import zipfile
import zlib
from dataclasses import asdict, replace
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from hmi.twin.errors import ModelError, UnsafeModel
from hmi.twin.limits import MAX_FILES, MAX_UNPACKED_BYTES, MAX_ZIP_BYTES
from hmi.twin.mesh_files import KINDS, MeshFolder, check_extent, is_file, plain_name
from hmi.twin.model import Mimic, Model, ModelJoint
from hmi.twin.skin import LinkSkin, Skin, skin_of
from hmi.twin.urdf import XACRO, parse_urdf

KEPT = {*KINDS, ".urdf", ".mtl", ".png", ".jpg", ".jpeg", ".txt", ".md", ".xacro"}
MODEL, SKIN = "model.json", "skin.npz"
_NAMES = (errno.EEXIST, errno.EISDIR, errno.ENOTDIR, errno.ENAMETOOLONG)


def read_upload(archive: Path, target: Path) -> dict[str, Any]:
    """Read a zip of one URDF and its meshes and keep it in ``target``, replacing what was there.

    Returns:
        ``name``, ``links``, ``joints`` (names of those that move), ``faces``, ``notices``.

    Raises:
        ModelError: see ``hmi.twin.errors``; ``target`` is left as it was.
    """
    folder = target.with_name(target.name + ".reading")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        _unpack(archive, folder / "files")
        urdf = _urdf_in(folder / "files")
        model = parse_urdf(urdf.read_bytes())
        meshes = MeshFolder(folder / "files") if urdf.parent == folder / "files" else _Nested(folder / "files", urdf)
        skin = skin_of(model, meshes.read)
        model = replace(model, notices=(*model.notices, *meshes.notices))
        _keep(model, skin, folder)
        shutil.rmtree(folder / "files")
        shutil.rmtree(target, ignore_errors=True)
        folder.rename(target)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return describe(model, skin.faces)


def load_kept(target: Path) -> tuple[Model, Skin]:
    """Return what ``read_upload`` kept.

    Raises:
        ModelError: nothing is there, or it was damaged.
    """
    try:
        known = json.loads((target / MODEL).read_text("utf-8"))
        with np.load(target / SKIN, allow_pickle=False) as arrays:
            links = {
                name: LinkSkin(arrays[f"corners{index}"], arrays[f"colours{index}"])
                for index, name in enumerate(known["skinned"])
            }
        joints = tuple(
            ModelJoint(**{**_tuples(one), "mimic": Mimic(**one["mimic"]) if one["mimic"] else None})
            for one in known["joints"]
        )
        model = Model(known["name"], known["root"], dict.fromkeys(known["links"], ()), joints, tuple(known["notices"]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ModelError(f"The kept model in {target.name} cannot be read. Upload it once more.") from error
    return model, Skin(links)


def describe(model: Model, faces: int) -> dict[str, Any]:
    """Return what people are told of a model."""
    return {
        "name": model.name,
        "links": len(model.links),
        "joints": [joint.name for joint in model.joints if joint.moves],
        "faces": faces,
        "notices": list(model.notices),
    }


class _Nested(MeshFolder):
    """Meshes named relative to a URDF that does not lie at the top of the upload."""

    def __init__(self, folder: Path, urdf: Path) -> None:
        super().__init__(folder)
        self._beside = urdf.parent.resolve()

    def _find(self, name: str, where: str) -> Path | None:
        text = plain_name(name)
        if not text.startswith("package://"):
            beside = (self._beside / text).resolve() if "\0" not in text else self._beside
            inside = beside.is_relative_to(self._folder) and "\0" not in text and not text.startswith("/")
            if inside and is_file(beside):
                return beside
            if inside and ":" not in text:
                return None
        return super()._find(name, where)


def _unpack(archive: Path, folder: Path) -> None:
    if archive.stat().st_size > MAX_ZIP_BYTES:
        raise UnsafeModel(f"The upload is over {MAX_ZIP_BYTES // 2**20} MB.")
    try:
        with zipfile.ZipFile(archive) as packed:
            entries = [entry for entry in packed.infolist() if not entry.is_dir()]
            _check_entries(entries)
            left = MAX_UNPACKED_BYTES
            for entry in entries:
                if _is_kept(entry.filename):
                    left -= _write(packed, entry, folder, left)
    except OSError as error:  # names of one file and of a folder alike, or longer than a file's may be
        if error.errno not in _NAMES:
            raise
        raise ModelError(
            "Two names in the zip contradict each other, or one is too long. Pack it once more."
        ) from error
    except (zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, NotImplementedError, RuntimeError) as error:
        raise ModelError("The upload is no zip file, or it is damaged or locked. Pack it once more.") from error


def _check_entries(entries: list[zipfile.ZipInfo]) -> None:
    if len(entries) > MAX_FILES:
        raise UnsafeModel(f"The zip holds {len(entries)} files, at most {MAX_FILES} are read.")
    if sum(entry.file_size for entry in entries) > MAX_UNPACKED_BYTES:
        raise UnsafeModel(f"Unpacked, the zip is over {MAX_UNPACKED_BYTES // 2**20} MB.")
    for entry in entries:
        path = PurePosixPath(entry.filename.replace("\\", "/"))
        is_link = (entry.external_attr >> 16) & 0o170000 == 0o120000
        if path.is_absolute() or ".." in path.parts or ":" in entry.filename or is_link:
            raise UnsafeModel(f'"{entry.filename[:80]}" in the zip leads out of its folder. It is refused.')


def _is_kept(name: str) -> bool:
    """Say whether a file is read; what macOS adds to a zip is called like its files and holds none of them."""
    path = PurePosixPath(name.replace("\\", "/"))
    return path.suffix.lower() in KEPT and "__MACOSX" not in path.parts and not path.name.startswith("._")


def _write(packed: zipfile.ZipFile, entry: zipfile.ZipInfo, folder: Path, most: int) -> int:
    path = folder / PurePosixPath(entry.filename.replace("\\", "/"))
    path.parent.mkdir(parents=True, exist_ok=True)
    with packed.open(entry) as source:
        data = source.read(most + 1)  # what the directory says of its size may be a lie
    if len(data) > most:
        raise UnsafeModel(f"Unpacked, the zip is over {MAX_UNPACKED_BYTES // 2**20} MB.")
    path.write_bytes(data)
    return len(data)


def _urdf_in(folder: Path) -> Path:
    files = sorted(folder.rglob("*")) if folder.is_dir() else []
    found = [path for path in files if path.suffix.lower() == ".urdf" and path.is_file()]
    if not found:
        if any(path.suffix.lower() == ".xacro" for path in files):
            raise ModelError(XACRO)
        raise ModelError("The zip holds no .urdf file.")
    if len(found) > 1:
        names = " and ".join(f'"{path.name}"' for path in found[:2])
        raise ModelError(f"The zip holds several URDF files, {names} among them. Leave one.")
    return found[0]


def _keep(model: Model, skin: Skin, folder: Path) -> None:
    arrays: dict[str, Any] = {}
    for index, (link, one) in enumerate(skin.links.items()):
        check_extent(one.corners, f'Link "{link}"')
        arrays[f"corners{index}"], arrays[f"colours{index}"] = one.corners, one.colours
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    (folder / SKIN).write_bytes(buffer.getvalue())
    known = {
        "name": model.name,
        "root": model.root,
        "links": list(model.links),
        "skinned": list(skin.links),
        "joints": [asdict(joint) for joint in model.joints],
        "notices": list(model.notices),
    }
    (folder / MODEL).write_text(json.dumps(known), encoding="utf-8")


def _tuples(values: dict[str, Any]) -> dict[str, Any]:
    return {key: tuple(value) if isinstance(value, list) else value for key, value in values.items()}
