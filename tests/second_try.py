"""Run pytest; the few tests that fail beside others are tried once more, alone, and named at the end.

The tests run real brokers, robots and browsers against real time, several at once. A machine that stands still for
a second in between makes an order stale, which Headland rightly refuses and a story rightly calls a failure. Alone,
such a story passes. What fails alone as well is wrong, and so is a run in which more than ``FEW`` fail.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

FEW = 5
_TESTS_FAILED = 1  # pytest's own number; others say that the run itself went wrong
_FAILED = Path(".pytest_cache/v/cache/lastfailed")


def run(arguments: Sequence[str]) -> int:
    """Run pytest with these arguments in the current folder; return its exit code, or the second try's."""
    _FAILED.unlink(missing_ok=True)
    code = _pytest(arguments)
    if code != _TESTS_FAILED or not _FAILED.exists():
        return code
    failed = sorted(json.loads(_FAILED.read_text("utf-8")))
    if not 0 < len(failed) <= FEW:
        return code
    names = "\n  ".join(failed)
    print(f"\nFailed beside others, tried once more alone:\n  {names}", flush=True)
    code = _pytest(["-n", "0", *failed])
    if code == 0:
        print(f"\nPassed alone, failed beside others (see above why):\n  {names}", flush=True)
    return code


def _pytest(arguments: Sequence[str]) -> int:
    return subprocess.run([sys.executable, "-m", "pytest", *arguments], check=False).returncode


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
