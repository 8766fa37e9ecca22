"""A test that failed beside others is tried alone: once, named, and only where few failed."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.second_try import FEW

ROOT = Path(__file__).parent.parent
LEAN = {"PYTHONPATH": str(ROOT), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTEST_ADDOPTS": "-p xdist.plugin"}
PASSES_AT_THE_SECOND_TRY = """
from pathlib import Path

def test_stutters():
    was_here = Path("was_here")
    if not was_here.exists():
        was_here.touch()
        raise AssertionError("late")

def test_is_well():
    Path("runs").open("a").write("x")
"""


def _run(folder: Path, tests: str) -> subprocess.CompletedProcess[str]:
    (folder / "test_it.py").write_text(tests, "utf-8")
    ours = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["pytest"]["ini_options"]
    (folder / "pytest.ini").write_text(f"[pytest]\naddopts = {ours['addopts']}\n", "utf-8")
    return subprocess.run(
        [sys.executable, "-m", "tests.second_try", "-q", "test_it.py"],
        cwd=folder, env=os.environ | LEAN, capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_what_passes_alone_passes_and_is_named(tmp_path: Path) -> None:
    done = _run(tmp_path, PASSES_AT_THE_SECOND_TRY)
    assert done.returncode == 0, done.stdout
    assert "Passed alone, failed beside others (see above why):\n  test_it.py::test_stutters" in done.stdout
    assert (tmp_path / "runs").read_text() == "x", "what passed is not run again"


def test_what_fails_alone_fails(tmp_path: Path) -> None:
    done = _run(tmp_path, "def test_wrong():\n    assert False")
    assert done.returncode == 1
    assert "tried once more alone" in done.stdout
    assert "Passed alone" not in done.stdout


def test_many_failures_get_no_second_try(tmp_path: Path) -> None:
    done = _run(tmp_path, PASSES_AT_THE_SECOND_TRY + "\n".join(f"def test_{n}(): assert 0" for n in range(FEW)))
    assert done.returncode == 1
    assert "tried once more" not in done.stdout


@pytest.mark.parametrize(("tests", "code"), [("def test_well(): pass", 0), ("import nowhere_to_be_found", 2)])
def test_other_ends_are_handed_on(tmp_path: Path, tests: str, code: int) -> None:
    assert _run(tmp_path, tests).returncode == code
