"""The rules of alarm tones, of the order of the alarm list, of what gives way to STOP, of words for times; in node."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
@pytest.mark.parametrize("name", ["alarm_tones", "alarm_order", "stop_sound", "stop_press", "words"])
def test_the_rules_of_the_browser_hold(name: str) -> None:
    node = shutil.which("node")
    assert node is not None
    run = subprocess.run(
        [node, "--test", "--test-reporter=tap", str(HERE / f"{name}.test.mjs")],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert run.returncode == 0, run.stdout[-4000:] + run.stderr[-2000:]
