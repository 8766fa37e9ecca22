"""A mission document as a text that a broker keeps: compressed, in letters no broker forbids, bounded both ways."""

from __future__ import annotations

import base64
import binascii
import zlib

from backend_clients.ngsi.errors import BadInput, Unreadable

MOST_PACKED = 900_000  # a request to a broker has a megabyte, and there is more in it
MOST_PLAIN = 8 * 1024 * 1024


def packed(document: bytes) -> str:
    """Return a document as text; raises ``BadInput`` if it is too large for the way through a cloud."""
    text = base64.urlsafe_b64encode(zlib.compress(document, 6)).rstrip(b"=").decode()
    if len(text) > MOST_PACKED:
        raise BadInput(f"a mission of {len(text)} bytes is too large for the way through the cloud")
    return text


def unpacked(text: str) -> bytes:
    """Return the document of a text; raises ``Unreadable``."""
    if len(text) > MOST_PACKED:
        raise Unreadable("a document that is too long")
    try:
        reader = zlib.decompressobj()
        found = reader.decompress(base64.urlsafe_b64decode(text + "=" * (-len(text) % 4)), MOST_PLAIN)
    except (ValueError, binascii.Error, zlib.error) as error:
        raise Unreadable("a document that cannot be unpacked") from error
    if reader.unconsumed_tail or not reader.eof:
        raise Unreadable("a document that is too long, or cut")
    return found
