"""Ids, types and names that a broker takes, and ids made from names of ours."""

from __future__ import annotations

import re
from typing import NamedTuple

from backend_clients.ngsi.errors import BadInput

MAX_LENGTH = 256
_ALLOWED = re.compile(r"[!-~]+", re.ASCII)
_FORBIDDEN = frozenset("&?/#<>\"'=;()")
_PLAIN = re.compile(rb"[A-Za-z0-9_.:-]")
PREFIX = "urn:ngsi-ld:"  # what the smart data models begin their ids with
RESERVED = ("id", "type")


class EntityRef(NamedTuple):
    """What names one entity within tenant and path: the id alone may stand for several types."""

    id: str
    type: str


def check_id(text: str) -> str:
    """Return ``text`` if it may be an id, a type or a name; raises ``BadInput``."""
    if not 0 < len(text) <= MAX_LENGTH:
        raise BadInput(f"an id has 1 to {MAX_LENGTH} characters, this one {len(text)}")
    if not _ALLOWED.fullmatch(text) or not _FORBIDDEN.isdisjoint(text):
        raise BadInput(f"not allowed in an id: {text[:80]!r}")
    return text


def check_attribute_name(text: str) -> str:
    """Return ``text`` if it may name an attribute; raises ``BadInput``."""
    if text in RESERVED:
        raise BadInput(f"{text!r} cannot be the name of an attribute")
    return check_id(text)


def check_ref(ref: EntityRef) -> EntityRef:
    """Return ``ref`` if both parts may be sent; raises ``BadInput``."""
    return EntityRef(check_id(ref.id), check_id(ref.type))


def ref_for(kind: str, name: str) -> EntityRef:
    """Return the entity of a thing of ours, e.g. ``urn:ngsi-ld:AgriParcel:north``; any text may be a name."""
    if not name:
        raise BadInput("a name must not be empty")
    return check_ref(EntityRef(f"{PREFIX}{kind}:{escaped_name(name)}", kind))


def escaped_name(name: str) -> str:
    """Return a name as part of an id: what an id may not have is ``~20`` and so on."""
    return "".join(chr(byte) if _PLAIN.fullmatch(bytes([byte])) else f"~{byte:02X}" for byte in _encoded(name))


def name_of(ref: EntityRef) -> str:
    """Return the name that ``ref_for`` was given; raises ``BadInput`` for an id of somebody else."""
    head = f"{PREFIX}{ref.type}:"
    if not ref.id.startswith(head):
        raise BadInput(f"not an id of ours: {ref.id[:80]!r}")
    plain = ref.id[len(head) :]
    try:
        found = re.sub(rb"~([0-9A-F]{2})", lambda code: bytes([int(code[1], 16)]), plain.encode()).decode()
    except UnicodeDecodeError as error:
        raise BadInput(f"not an id of ours: {ref.id[:80]!r}") from error
    if not found or ref_for(ref.type, found) != ref:
        raise BadInput(f"not an id of ours: {ref.id[:80]!r}")
    return found


def _encoded(name: str) -> bytes:
    try:
        return name.encode("utf-8")
    except UnicodeEncodeError as error:
        raise BadInput("a name must be valid Unicode") from error
