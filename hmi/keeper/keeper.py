"""Start all parts, watch them, restart what falls, end everything in order."""

from __future__ import annotations

import logging
import math
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FrameType

import psutil

from hmi.keeper.data_folder import overwrite_json, read_json, write_json
from hmi.keeper.errors import StartError
from hmi.keeper.part import Part, PartSpec

WATCH_S = 0.1
START_LIMIT_S = 60.0
LATER_S = 5.0  # whoever waited for the start signs in now; what can wait leaves them the machine
LATER_EACH_S = 10.0  # a part that can wait and does not come up holds up the next one no longer than this
WRITE_AGAIN_S = 1.0
END_LIMIT_S = 2.0  # with a second to spare for the promise of three
log = logging.getLogger(__name__)


class Keeper:
    """Keeps the parts of one installation running until told to end.

    Its view goes to ``run/keeper.json``, where the console reads it for health and the screens.

    Args:
        parts: what to run; each starts as soon as those it comes ``after`` serve. They end in reverse order.
        later: parts nobody waits for; they start once everything else serves, one after the other.
    """

    def __init__(self, parts: Sequence[PartSpec], data: Path, later: Sequence[PartSpec] = ()) -> None:
        self._data = data
        self._first = [Part(spec, data / "logs") for spec in parts]
        self._later = [Part(spec, data / "logs") for spec in later]
        self._parts = [*self._first, *self._later]
        self._end = threading.Event()
        self._later_s = 0.0
        self._write_again_s = math.inf

    def run(self, on_ready: Callable[[], None]) -> None:
        """Start everything, call ``on_ready`` once all parts serve, and watch until a signal or ``end``.

        Raises:
            StartError: a part did not become ready; its last log lines are in the message.
        """
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._signalled)
        end_left_overs(self._data)
        try:
            self._start()
            if not self._end.is_set():
                on_ready()
            self._later_s = time.monotonic() + LATER_S
            while not self._end.wait(WATCH_S):
                self._start_later()
                self._watch()
        finally:
            self._end_all()

    def end(self) -> None:
        """Let ``run`` return after ending all parts."""
        self._end.set()

    def _start_later(self) -> None:
        """Start the next part nobody waits for, when the one before serves or took its time."""
        waiting = [part for part in self._later if part.state == "stopped"]
        begun = self._later[: len(self._later) - len(waiting)]
        is_free = not begun or begun[-1].state == "ok"
        now_s = time.monotonic()
        if waiting and now_s >= self._later_s and (is_free or now_s >= self._later_s + LATER_EACH_S):
            waiting[0].start_if_possible()
            self._later_s = now_s
            self._write()

    def _start(self) -> None:
        deadline_s = time.monotonic() + START_LIMIT_S
        while not self._end.is_set() and any(part.state != "ok" for part in self._first):
            self._start_due()
            self._watch()
            fallen = next((p for p in self._first if p.restarts > 2), None)
            late = next((p for p in self._first if p.state != "ok"), None) if time.monotonic() > deadline_s else None
            if failed := fallen or late:
                raise StartError(f"{failed.spec.name} does not start. Its log ends with:\n{failed.log_tail()}")
            self._end.wait(0.03)

    def _start_due(self) -> None:
        serving = {part.spec.name for part in self._first if part.state == "ok"}
        due = [part for part in self._first if part.state == "stopped" and serving.issuperset(part.spec.after)]
        for part in due:
            part.start()
        if due:
            self._write()

    def _watch(self) -> None:
        # a part that was not started yet is "stopped" and is not missed
        changed = [part.watch() for part in self._parts if part.state != "stopped"]  # every part, no short cut
        if any(changed) or time.monotonic() >= self._write_again_s:
            self._write()

    def _write(self) -> None:
        """Say how the parts are; a full disk must not end them."""
        view = {"pid": os.getpid(), "parts": {part.spec.name: part.describe() for part in self._parts}}
        path = self._data / "run" / "keeper.json"
        try:
            try:
                write_json(path, view)
            except OSError:
                overwrite_json(path, view)  # else a part that fell would be said to run
        except OSError as error:
            if self._write_again_s == math.inf:
                log.error("keeper.json cannot be written, it is tried again: %s", error)
            self._write_again_s = time.monotonic() + WRITE_AGAIN_S
        else:
            self._write_again_s = math.inf

    def _end_all(self) -> None:
        for part in reversed(self._parts):
            part.terminate()
        deadline_s = time.monotonic() + END_LIMIT_S
        for part in reversed(self._parts):
            part.wait(deadline_s)
        (self._data / "run" / "keeper.json").unlink(missing_ok=True)

    def _signalled(self, number: int, frame: FrameType | None) -> None:
        self._end.set()


def end_left_overs(data: Path) -> None:
    """End parts that an earlier keeper of this data folder left running when it was killed.

    Raises:
        StartError: the earlier keeper still runs.
    """
    before = read_json(data / "run" / "keeper.json")
    if not isinstance(before, dict):
        return
    keeper_pid = before.get("pid")
    if isinstance(keeper_pid, int) and keeper_pid != os.getpid() and _is_ours(keeper_pid):
        raise StartError(f"Headland already runs with the data folder {data} (process {keeper_pid}).")
    left = [p for part in before.get("parts", {}).values() if (p := _process(part.get("pid"))) is not None]
    for process in left:
        process.terminate()
    for process in psutil.wait_procs(left, timeout=END_LIMIT_S)[1]:
        process.kill()


def _process(pid: object) -> psutil.Process | None:
    return psutil.Process(pid) if isinstance(pid, int) and _is_ours(pid) else None


def _is_ours(pid: int) -> bool:
    """Say whether ``pid`` runs a program of ours; pids are reused, so a number alone proves nothing."""
    try:
        words = " ".join(psutil.Process(pid).cmdline())
    except psutil.Error:
        return False
    return "headland" in words or "hmi.cli" in words or "mosquitto -c" in words
