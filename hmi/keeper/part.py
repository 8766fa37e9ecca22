"""One watched process: how it starts, when it is ready, how long it waits before another try."""

from __future__ import annotations

import ctypes
import logging
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, BinaryIO

BACKOFF_S = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
STEADY_S = 30.0  # a part that ran this long starts again with the shortest wait
LOG_LIMIT_BYTES = 5 * 1024 * 1024
PR_SET_PDEATHSIG = 1
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class PartSpec:
    """What a part is.

    Args:
        argv: command and arguments.
        is_ready: says whether it serves; asked until true at each start.
        url: where it can be reached, for health and people; ``None`` if nowhere.
        after: names of the parts that have to serve before this one is started for the first time.
    """

    name: str
    argv: tuple[str, ...]
    env: dict[str, str] = field(default_factory=dict)
    is_ready: Callable[[], bool] = lambda: True
    url: str | None = None
    dies_with_keeper: bool = False
    after: tuple[str, ...] = ()


class Part:
    """A process that is kept running."""

    def __init__(self, spec: PartSpec, logs: Path) -> None:
        self.spec = spec
        self._log = logs / f"{spec.name}.log"
        self._process: subprocess.Popen[bytes] | None = None
        self._started_s = 0.0
        self._next_start_s = 0.0
        self._failures = 0
        self.restarts = 0
        self.state = "stopped"
        self.down_since: datetime | None = None
        self.last_down: dict[str, Any] | None = None

    @property
    def pid(self) -> int | None:
        """Process id while it runs."""
        return self._process.pid if self._process and self._process.poll() is None else None

    def start(self) -> None:
        """Start the process; its output goes to its log."""
        dies = self.spec.dies_with_keeper and sys.platform == "linux"
        with self._output() as log:
            # its own session: Ctrl+C reaches the keeper alone, which then ends the parts in order
            self._process = subprocess.Popen(  # noqa: S603 - our own programs
                self.spec.argv,
                env={**os.environ, **self.spec.env},
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,
                preexec_fn=_die_with_parent if dies else None,  # noqa: PLW1509 - before any thread exists
            )
        self._started_s = time.monotonic()
        self.state = "starting"

    def start_if_possible(self) -> None:
        """Start the process, later where the system has no room for one: the other parts, STOP first, go on."""
        try:
            self.start()
        except (OSError, subprocess.SubprocessError) as error:
            log.error("%s cannot be started, it is tried again: %s", self.spec.name, error)
            self._process, self._started_s, self.state = None, time.monotonic(), "starting"

    def watch(self) -> bool:
        """Look at the process once, restart it when due; return whether anything changed."""
        before = (self.state, self.pid)
        if self.pid is None:
            self._restart_when_due()
        elif self.state != "ok" and self.spec.is_ready():
            self.state = "ok"
            if self.down_since is not None:
                self.last_down = {
                    "from_utc": self.down_since.isoformat(timespec="milliseconds"),
                    "until_utc": datetime.now(UTC).isoformat(timespec="milliseconds"),
                }
                self.down_since = None
        return before != (self.state, self.pid)

    def _output(self) -> BinaryIO:
        """Open its log, nothing where the disk is full: a part runs without one."""
        try:
            if self._log.exists() and self._log.stat().st_size > LOG_LIMIT_BYTES:
                self._log.replace(self._log.with_suffix(".log.1"))
            return self._log.open("ab")
        except OSError:
            return Path(os.devnull).open("ab")

    def _restart_when_due(self) -> None:
        now = time.monotonic()
        if self.state != "down":
            if now - self._started_s > STEADY_S:
                self._failures = 0
            wait = BACKOFF_S[min(self._failures, len(BACKOFF_S) - 1)]
            self._failures += 1
            self._next_start_s = now + wait
            self.state = "down"
            self.down_since = self.down_since or datetime.now(UTC)
        if now >= self._next_start_s:
            self.restarts += 1
            self.start_if_possible()

    def terminate(self) -> None:
        """Ask the process to end."""
        if self._process and self._process.poll() is None:
            self._process.terminate()
        self.state = "stopped"

    def wait(self, deadline_s: float) -> None:
        """Wait until the process ended, at the latest until ``deadline_s`` (monotonic), then kill it."""
        if self._process is None:
            return
        try:
            self._process.wait(max(0.0, deadline_s - time.monotonic()))
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def log_tail(self, lines: int = 12) -> str:
        """Return the last lines of its log."""
        try:
            text = self._log.read_text(encoding="utf-8", errors="replace")
        except OSError:
            return ""
        return "\n".join(text.splitlines()[-lines:])

    def describe(self) -> dict[str, Any]:
        """Return what health shows of this part."""
        return {
            "state": self.state,
            "pid": self.pid,
            "url": self.spec.url,
            "restarts": self.restarts,
            "down_since_utc": self.down_since.isoformat(timespec="milliseconds") if self.down_since else None,
            "last_down": self.last_down,
        }


def _die_with_parent() -> None:
    # a demo leaves nothing behind even when its keeper is killed; a real installation keeps STOP alive instead
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
