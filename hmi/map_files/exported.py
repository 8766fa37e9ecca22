"""A map file to hand out."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element, indent, tostring

_STAMP = (1980, 1, 1, 0, 0, 0)  # the same map is the same file, byte for byte
_FILE_MODE = 0o644 << 16


@dataclass(frozen=True, slots=True)
class MapFile:
    """The bytes of a file, and what to call it.

    Attributes:
        left_out: names of features that the format has no place for.
        cut: sentences about what features lose in it.
    """

    data: bytes
    media_type: str
    file_name: str
    left_out: tuple[str, ...] = ()
    cut: tuple[str, ...] = ()


def packed(files: Mapping[str, bytes]) -> bytes:
    """Return a zip archive of files by path, in the order given."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            info = zipfile.ZipInfo(path, _STAMP)
            info.compress_type, info.create_system, info.external_attr = zipfile.ZIP_DEFLATED, 3, _FILE_MODE
            archive.writestr(info, data)
    return stream.getvalue()


def xml_bytes(root: Element) -> bytes:
    """Return an XML document in UTF-8."""
    indent(root, " ")
    data: bytes = tostring(root, encoding="UTF-8", xml_declaration=True)
    return data + b"\n"


def json_bytes(value: Any) -> bytes:
    """Return a JSON text in UTF-8."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, indent=1).encode("utf-8") + b"\n"


def stem(farm_id: str) -> str:
    """Return a file name without suffix that every system takes."""
    return re.sub(r"[^a-z0-9_-]+", "-", farm_id.lower()).strip("-")[:64] or "farm"


def number(value: float) -> str:
    """Return a coordinate in degrees without exponent, 8 decimals at most."""
    return f"{value:.8f}".rstrip("0").rstrip(".")


def titles(features: Sequence[Any]) -> tuple[str, ...]:
    """Return what to call features in a sentence."""
    return tuple(feature.title for feature in features)
