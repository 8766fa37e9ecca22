"""What the live map costs and carries: size, licences, no traces of other hosts."""

from __future__ import annotations

import re
from pathlib import Path

import brotli

STATIC = Path(__file__).resolve().parents[2] / "static"
VENDOR = STATIC / "vendor" / "maplibre"
CODE = STATIC / "js" / "map"
MOST_BYTES = 450_000  # as brotli at the quality we serve: MapLibre, its worker, and the map's own files
MOST_LINES = 400


def loaded_at_first() -> set[Path]:
    """Return the scripts that every map fetches: what is imported on the way, not what is asked for later."""
    found: set[Path] = set()
    waiting = [CODE / "live_map.js", CODE / "gl_engine.js"]
    while waiting:
        script = waiting.pop()
        if script not in found:
            found.add(script)
            waiting += [CODE / name for name in re.findall(r"""from '\./([\w.]+)'""", script.read_text("utf-8"))]
    return found


def test_the_map_stays_within_its_weight() -> None:
    files = [*VENDOR.glob("*.mjs"), *VENDOR.glob("*.css"), CODE / "map.css", *loaded_at_first()]
    weight = sum(len(brotli.compress(path.read_bytes(), quality=9)) for path in files)
    assert weight <= MOST_BYTES


def test_the_scripts_of_the_map_stay_small() -> None:
    long = {path.name for path in CODE.glob("*.js") if len(path.read_text("utf-8").splitlines()) >= MOST_LINES}
    assert long == set()


def test_the_vendored_library_comes_with_its_licences_and_without_source_maps() -> None:
    assert "MapLibre contributors" in (VENDOR / "LICENSE.txt").read_text("utf-8")
    assert "MapLibre GL JS" in (STATIC.parent / "NOTICE").read_text("utf-8")
    assert len(re.findall("^=== ", (VENDOR / "THIRD_PARTY.txt").read_text("utf-8"), re.MULTILINE)) == 17
    for path in VENDOR.glob("*.mjs"):
        assert "sourceMappingURL" not in path.read_text("utf-8")


def test_the_scripts_of_the_map_name_no_other_host() -> None:
    for path in CODE.iterdir():
        hosts = set(re.findall(r"(?:https?:)?//([a-z0-9.-]+\.[a-z]{2,})/", path.read_text("utf-8")))
        assert hosts <= {"www.w3.org"}, path.name
