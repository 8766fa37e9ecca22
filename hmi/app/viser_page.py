"""viser's client, put together again for our origin: its page with our script, its code as a file of its own.

viser is never imported here: the console stays light, and what viser's client may do is decided by the page's policy.
"""

from __future__ import annotations

import gzip
import hashlib
import json
import re
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from hmi.pages import bundle

_LOADER = re.compile(
    r'<script data-p="(?P<p>[^"]*)" data-ss="(?P<ss>\d+)" data-cs="(?P<cs>\d+)">(?P<code>.*?)</script>', re.DOTALL
)
_NEEDED = ("document.currentScript.dataset", 'document.createElement("script")', "WebAssembly.instantiate")
CLIENT_PATH = "/viser/client.js"


class ViserChanged(Exception):
    """viser's client is not the one these injections were made for."""


@dataclass(frozen=True, slots=True)
class ViserPage:
    """The page, and the client's code as it is served: packed, with the address it may be kept under for good."""

    html: bytes
    code: bytes
    code_packed: bytes
    code_url: str


@cache
def viser_page() -> ViserPage:
    """Return the page.

    Raises:
        ViserChanged: the installed viser has another client.
    """
    return patched(client_file().read_text("utf-8"))


def client_file() -> Path:
    """Return where the installed viser keeps its client."""
    spec = find_spec("viser")
    if spec is None or not spec.submodule_search_locations:
        raise ViserChanged("viser is not installed")
    return Path(next(iter(spec.submodule_search_locations))) / "client" / "build" / "index.html"


def patched(text: str) -> ViserPage:
    """Return the page made of viser's own; raises ``ViserChanged``."""
    found = _LOADER.search(text)
    if found is None or text.count("<script") != 1 or "</head>" not in text:
        raise ViserChanged("viser's page is built in another way")
    for part in _NEEDED:
        if part not in found["code"]:
            raise ViserChanged(f"viser's loader has no {part}")
    code = _code(found).encode()
    url = f"{CLIENT_PATH}?v={hashlib.sha256(code).hexdigest()[:12]}"
    ours = (
        f'<link rel="stylesheet" href="{bundle.versioned("css/viser_frame.css")}">'
        f'<script src="{bundle.versioned("js/viser_frame.js")}"></script><script src="{url}"></script>'
    )
    page = text[: found.start()] + text[found.end() :]
    page = page.replace("</head>", f"{ours}</head>").replace("<title>Viser</title>", "<title>3D twin</title>")
    return ViserPage(page.encode(), code, gzip.compress(code, 6), url)


def _code(found: re.Match[str]) -> str:
    data = {key: found[key] for key in ("p", "ss", "cs")}
    return f"Object.assign(document.currentScript.dataset,{json.dumps(data)});\n{found['code']}"
