"""The STOP slab: what a page's head needs so that STOP works without the page's framework.

The scripts make the slab's own root after ``#q-app`` and keep their own connection; nothing of it goes through
the page's socket. See ``static/js/stop.js`` for what other scripts may call.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from html import escape

SCRIPTS = ("stop_press", "stop_link", "stop_sound", "stop_words", "stop_view", "stop_card", "stop")
"""Load order; each file uses only names of those before it."""

STYLE = "css/stop.css"
CONFIG_ID = "headland-stop-config"


@dataclass(frozen=True, slots=True)
class StopConfig:
    """Where STOP goes from this page.

    Args:
        base: public address of the gateway; empty for the page's own host with ``port``.
        port: the gateway's port.
        console_base: address before ``/api/v1``; empty for the page's own origin.
        robot: id and name of the robot the slab stops first; ``None`` for all.
        csrf: the session's token for the console's REST, empty where nobody is signed in.
        note: words after READY, e.g. ``no sign-in needed``.
    """

    base: str = ""
    port: int = 0
    console_base: str = ""
    robot: tuple[str, str] | None = None
    csrf: str = ""
    note: str = ""

    def as_json(self) -> str:
        """Return the configuration as the scripts read it, safe inside a ``<script>`` element."""
        scope = {"kind": "robot", "id": self.robot[0], "name": self.robot[1]} if self.robot else {"kind": "all"}
        fields = {
            "base": self.base.rstrip("/"),
            "port": self.port,
            "consoleBase": self.console_base.rstrip("/"),
            "csrf": self.csrf,
            "note": self.note,
            "scope": scope,
        }
        return json.dumps(fields).replace("<", "\\u003c")


def head_html(config: StopConfig, *, address: Callable[[str], str] | None = None, nonce: str = "") -> str:
    """Return the elements for the page's ``<head>``.

    Args:
        config: where STOP goes.
        address: turns a path below ``static`` into its (versioned) address; ``/static/...`` by default.
        nonce: of the page's content security policy; empty where something else adds it.
    """
    where = address or "/static/{}".format
    mark = f' nonce="{escape(nonce)}"' if nonce else ""
    scripts = "".join(f'<script defer src="{escape(where(f"js/{name}.js"))}"{mark}></script>' for name in SCRIPTS)
    return (
        f'<link rel="stylesheet" href="{escape(where(STYLE))}">'
        f'<script type="application/json" id="{CONFIG_ID}"{mark}>{config.as_json()}</script>{scripts}'
    )
