"""Icons are cut to those in use: every name in the code is in the font's list, and nothing is listed in vain."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
LISTED = (ROOT / "static/icons/icons.txt").read_text("utf-8").split()
SOURCES = [
    *(ROOT / "static/js").glob("*.js"),
    *(ROOT / "static/js/ui").glob("*.js"),
    *(ROOT / "static/js/camera").glob("*.js"),
    *(ROOT / "hmi/pages").glob("*.py"),
    *(ROOT / "components").glob("*.py"),
]
NAMED = re.compile(r"""(?:icon\(\s*|(?:sign|icon|goal):\s*)["']([a-z_0-9]+)["']""")
OWN_DRAWINGS = {"octagon", "lock", "hand"}  # the slab draws its signs itself


def code() -> str:
    """Return all sources that may name an icon."""
    return "\n".join(path.read_text("utf-8") for path in SOURCES)


def test_every_icon_named_in_the_code_is_in_the_font() -> None:
    named = set(NAMED.findall(code())) - OWN_DRAWINGS
    assert len(named) > 25, "the pattern no longer finds the icons"
    assert named - set(LISTED) == set()


def test_no_icon_is_carried_that_nobody_names() -> None:
    text = code()
    assert [name for name in LISTED if not re.search(rf"""["'>]{name}["'<]""", text)] == []


def test_the_list_is_sorted_and_the_font_small() -> None:
    assert sorted(set(LISTED)) == LISTED
    assert (ROOT / "static/icons/material-symbols.woff2").stat().st_size < 16_000
