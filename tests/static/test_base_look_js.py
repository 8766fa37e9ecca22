"""How a photo is washed out below the map, run in node."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_lines_stand_out_of_any_photo_in_every_theme() -> None:
    node = shutil.which("node")
    assert node is not None
    run = subprocess.run(
        [node, "--test", "--test-reporter=tap", str(HERE / "base_look.test.mjs")],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert run.returncode == 0, run.stdout[-4000:] + run.stderr[-2000:]
