"""The hash chain of the audit: how an entry is made plain, hashed, and checked."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import Enum
from typing import Any, Protocol

GENESIS = "0" * 64
MAX_DATA_CHARS = 65_536
_MAX_DEPTH = 8
_BIGGEST = 2**63
_WIDTHS = {"farm_id": 64, "actor": 80, "device": 80, "kind": 32, "robot_id": 64, "ref": 64, "outcome": 32, "text": 4000}


class AuditLine(Protocol):
    """What one line of the audit says; anything with these attributes will do."""

    @property
    def farm_id(self) -> str:
        """The farm it belongs to."""
        ...

    @property
    def actor(self) -> str:
        """Name of the person, or ``system``."""
        ...

    @property
    def device(self) -> str:
        """Name of the tablet, empty if it has none."""
        ...

    @property
    def kind(self) -> str:
        """What it is about: command, stop, lease, sign_in, account, device, robot, mission ..."""
        ...

    @property
    def outcome(self) -> str:
        """What came of it: accepted, rejected, timed_out, unknown, pending, refused, ok ..."""
        ...

    @property
    def robot_id(self) -> str | None:
        """The robot, if it is about one."""
        ...

    @property
    def ref(self) -> str:
        """Id of the command, press, mission or account."""
        ...

    @property
    def text(self) -> str:
        """One sentence."""
        ...

    @property
    def data(self) -> Mapping[str, Any] | None:
        """Details that can be written as JSON."""
        ...


@dataclass(frozen=True, slots=True)
class AuditEntry:
    """An ``AuditLine`` as plain values."""

    farm_id: str
    actor: str
    device: str
    kind: str
    outcome: str
    robot_id: str | None = None
    ref: str = ""
    text: str = ""
    data: Mapping[str, Any] | None = None


def plain_fields(entry: AuditLine, at: datetime) -> dict[str, Any]:
    """Return the columns of an entry, so clean that no database can refuse them and reading gives the same back."""
    at = at.astimezone(UTC)
    fields: dict[str, Any] = {name: _text(getattr(entry, name), width) for name, width in _WIDTHS.items()}
    fields["at"] = at.replace(microsecond=at.microsecond // 1000 * 1000)  # as fine as it is stored
    fields["data"] = _bounded(plain(entry.data or {}))
    return fields


def digest(previous_hash: str, fields: Mapping[str, Any]) -> str:
    """Return the SHA-256 of an entry and of the hash before it."""
    content = {
        **{name: fields[name] for name in _WIDTHS},
        "at": fields["at"].isoformat(timespec="milliseconds"),
        "data": fields["data"],
        "previous_hash": previous_hash,
    }
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def plain(value: Any, depth: int = 0) -> Any:
    """Return ``value`` as JSON can carry it: no NaN, no NUL, no foreign types, not too deep."""
    if depth > _MAX_DEPTH:
        return "..."
    if isinstance(value, Enum):
        return plain(value.value, depth)
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        return value if -_BIGGEST <= value < _BIGGEST else hex(value)[:40]
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, Mapping):
        return {clean(str(key)): plain(item, depth + 1) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item, depth + 1) for item in value]
    return clean(str(value))


def clean(text: str) -> str:
    """Take out what PostgreSQL (NUL) or UTF-8 (lone surrogates) cannot store."""
    return text.replace("\x00", "").encode("utf-8", "replace").decode("utf-8")


def _text(value: str | None, width: int) -> str | None:
    return None if value is None else clean(str(plain(value)))[:width]


def _bounded(data: Any) -> Any:
    text = json.dumps(data)
    return data if len(text) <= MAX_DATA_CHARS else {"shortened": True, "head": text[:1000]}
