"""JSON from strangers: whole, or one object a line (RFC 7464 and newline-delimited JSON)."""

from __future__ import annotations

import codecs
import json
from typing import Any

from hmi.map_files.errors import BadMapFile

_BOMS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))


def decoded(data: bytes) -> str:
    """Return the text of a file: by its byte order mark, else UTF-8, else as Windows writes it."""
    encoding = next((name for bom, name in _BOMS if data.startswith(bom)), "utf-8")
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def whole(text: str) -> Any:
    """Return the value of a JSON text.

    Raises:
        BadMapFile: it is none.
    """
    try:
        return json.loads(text)
    except RecursionError as error:
        raise BadMapFile("broken_json", "The JSON is nested too deeply for a map. It is refused.") from error
    except ValueError as error:
        where = f" in line {error.lineno}" if isinstance(error, json.JSONDecodeError) else ""
        text = f"The JSON is broken{where}, or the file is cut off. Export or download it once more."
        raise BadMapFile("broken_json", text) from error


def by_line(text: str) -> list[tuple[int, Any]] | None:
    """Return number and value of each line, the value None where it is no object; None if the first line is none."""
    lines = [(n, line.strip().lstrip("\x1e")) for n, line in enumerate(text.split("\n"), start=1)]
    values = [(n, _object(line)) for n, line in lines if line]
    return values if values and values[0][1] is not None else None


def _object(line: str) -> Any:
    try:
        value = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return value if isinstance(value, dict) else None
