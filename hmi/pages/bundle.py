"""The console's own styles and scripts, joined into two files whose address carries their hash.

The parts stay small in the source tree; a browser fetches one style sheet and one script and keeps both for good.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache
from pathlib import Path

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

STATIC = Path(__file__).resolve().parents[2] / "static"

STYLES = ("tokens", "base", "frame", "panel", "control", "screens", "missions")
"""Cascade order: tokens first, screens last."""

SCRIPTS = (
    "core", "glyphs", "words", "preferences", "units", "port", "stops", "sheet",
    "banner", "top_bar", "menus", "telemetry_tile", "mission_card", "state_path", "why",
    "slide_to_confirm", "lease", "hold_to_drive", "stop_card", "action_dock",
    "sign_in", "fleet_list", "records", "admin_forms",
    "field_picture", "mission_numbers", "mission_form", "missions", "screen", "keys",
)  # fmt: skip
"""Load order: each file uses only names of those before it."""

_URL = re.compile(r"url\(\.\./([\w./-]+)\)")


def versioned(path: str) -> str:
    """Return the address of a file below ``static`` with the hash of its content, for caching without end.

    Raises:
        FileNotFoundError: there is no such file.
    """
    return f"/static/{path}?v={_digest((STATIC / path).read_bytes())}"


@cache
def style_sheet() -> bytes:
    """Return all styles; the fonts they name carry their hashes."""
    text = "\n".join((STATIC / "css" / f"{name}.css").read_text("utf-8") for name in STYLES)
    return _URL.sub(lambda found: f"url({versioned(found[1])})", text).encode()


@cache
def script() -> bytes:
    """Return all scripts of the screens, in load order."""
    return "\n;\n".join((STATIC / "js" / "ui" / f"{name}.js").read_text("utf-8") for name in SCRIPTS).encode()


def style_url() -> str:
    """Return the versioned address of the style sheet."""
    return f"/static/bundle/headland.css?v={_digest(style_sheet())}"


def script_url() -> str:
    """Return the versioned address of the script."""
    return f"/static/bundle/headland.js?v={_digest(script())}"


def routes() -> list[Route]:
    """Return the routes that serve the two files; they come before the mount of ``/static``."""
    return [Route("/static/bundle/headland.css", _style), Route("/static/bundle/headland.js", _script)]


def _style(_request: Request) -> Response:
    return Response(style_sheet(), media_type="text/css")


def _script(_request: Request) -> Response:
    return Response(script(), media_type="application/javascript")


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:12]
