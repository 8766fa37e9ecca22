"""Processes start without what they never use, and can use it afterwards."""

from __future__ import annotations

import subprocess
import sys

import pytest

PARTS = {
    "the console": ("from hmi.app import LEANLY, lean_start\nwith lean_start(*LEANLY): import hmi.app.server"),
    "the STOP gateway": "import hmi.stop_gateway.__main__",
    "the keeper": "import hmi.cli, hmi.keeper.installation, hmi.demo.fleet",
}
HEAVY = {
    "the console": (
        "aiohttp",
        "dns",
        "numpy",
        "shapely",
        "pyproj",
        "shapefile",
        "requests",
        "rich",
        "alembic",
        "backend_clients.simulator",
        "viser",
        "scipy",
        "rasterio",
    ),
    "the STOP gateway": ("rich", "nicegui", "sqlalchemy", "numpy"),
    "the keeper": ("nicegui", "sqlalchemy", "numpy", "pyproj", "cryptography", "fastapi"),
}


def told(code: str) -> str:
    """Run ``code`` in a Python of its own; return what it printed."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    return done.stdout.strip()


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.slow
def test_a_process_starts_without_what_it_does_not_need(part: str) -> None:
    code = f"{PARTS[part]}\nimport sys; print([name for name in {HEAVY[part]} if name in sys.modules])"
    assert told(code) == "[]"


def test_what_was_left_out_can_be_imported_later_and_garbage_is_collected_again() -> None:
    code = (
        "from hmi.lean_start import lean_start\n"
        "with lean_start('engineio'): pass\n"
        "import gc, aiohttp\n"
        "print(gc.isenabled(), aiohttp.__name__)"
    )
    assert told(code) == "True aiohttp"
