"""The layout of state charts and the rows of durations, run in node."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_charts_and_durations_keep_their_rules() -> None:
    node = shutil.which("node")
    assert node is not None
    run = subprocess.run(
        [node, "--test", "--test-reporter=tap", str(HERE / "chart.test.mjs")],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert run.returncode == 0, run.stdout[-4000:] + run.stderr[-2000:]
