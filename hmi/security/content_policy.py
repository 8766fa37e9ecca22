"""The content security policy, and the nonce in every script tag of a page."""

from __future__ import annotations

import re
import secrets
from urllib.parse import urlsplit

# A script with all its text, or a comment: what looks like a tag inside either is none.
_SCRIPT = re.compile(rb"<!--.*?-->|<script\b([^>]*)>.*?</script\s*>", re.DOTALL | re.IGNORECASE)
_OWN_NONCE = re.compile(rb"""\snonce\s*=\s*("[^"]*"|'[^']*'|[^\s>]+)""", re.IGNORECASE)
_OPENING = len(b"<script")


def new_nonce() -> str:
    """Return a fresh nonce, 128 bit."""
    return secrets.token_urlsafe(16)


def page_policy(nonce: str, host: str, stop_url: str | None, tiles_origin: str | None = None) -> str:
    """Return the policy of one page.

    Vue compiles templates at run time (``unsafe-eval``), Quasar sets style attributes (``unsafe-inline``); everything
    else comes from this origin, and the only other places to talk to are the STOP gateway and, where an admin has
    set one, the server of the online map.

    Args:
        nonce: what the page's script tags carry.
        host: the ``Host`` of the request, already checked.
        stop_url: public address of the STOP gateway for this host.
        tiles_origin: scheme, host and port of the online map, if there is one.
    """
    tiles = [tiles_origin] if tiles_origin else []
    # 'self' does not cover websockets in older Safari, so they are named.
    connect = ["'self'", f"ws://{host}", f"wss://{host}", *_stop_sources(stop_url), *tiles]
    return "; ".join((
        "default-src 'self'",
        f"script-src 'self' 'nonce-{nonce}' 'unsafe-eval'",
        "script-src-attr 'none'",
        "style-src 'self' 'unsafe-inline'",
        " ".join(("img-src 'self' data: blob:", *tiles)),
        "font-src 'self' data:",
        "media-src 'self' blob:",
        f"connect-src {' '.join(connect)}",
        "worker-src 'self' blob:",
        "frame-src 'self'",
        "object-src 'none'",
        "base-uri 'none'",
        "form-action 'self'",
        "frame-ancestors 'self'",
    ))  # fmt: skip


VIEWER_PATH = "/viser/"
"""Below this the page of the 3D twin lives, which has a policy of its own."""


def viewer_policy(nonce: str, host: str) -> str:
    """Return the policy of the twin's page: its worker is made of a blob, nothing comes from or goes elsewhere."""
    return "; ".join((
        "default-src 'none'",
        f"script-src 'self' 'nonce-{nonce}' 'unsafe-eval'",
        "script-src-attr 'none'",
        "style-src 'self' 'unsafe-inline'",
        "img-src 'self' data: blob:",
        "font-src 'self' data:",
        f"connect-src 'self' ws://{host} wss://{host} data: blob:",
        "worker-src blob:",
        "object-src 'none'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'self'",
    ))  # fmt: skip


DOCUMENT_POLICY = "default-src 'none'; style-src 'unsafe-inline'; sandbox; frame-ancestors 'none'"
"""For what is no page but can be opened like one (SVG, XML): nothing runs in it."""


def with_nonce(html: bytes, nonce: str) -> bytes:
    """Return a page whose script tags carry ``nonce``; tags inside comments and scripts are left alone."""
    attribute = f' nonce="{nonce}"'.encode()

    def mark(match: re.Match[bytes]) -> bytes:
        text = match[0]
        if match[1] is None:
            return text
        attributes = _OWN_NONCE.sub(b"", match[1])
        return text[:_OPENING] + attribute + attributes + text[_OPENING + len(match[1]) :]

    return _SCRIPT.sub(mark, html)


def _stop_sources(stop_url: str | None) -> list[str]:
    if not stop_url:
        return []
    parts = urlsplit(stop_url)
    socket = "wss" if parts.scheme == "https" else "ws"
    return [f"{parts.scheme}://{parts.netloc}", f"{socket}://{parts.netloc}"]
