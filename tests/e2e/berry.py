"""The berry picker of docs/describe_your_robot.md, on the demo's broker."""

from __future__ import annotations

import importlib.util
import threading
import time
from pathlib import Path
from types import ModuleType, TracebackType

from backend_clients.edge.mqtt import MqttLink
from backend_clients.edge.topics import Up, topic

SCRIPT = Path(__file__).parents[2] / "docs/plans/berry_picker.py"
PERIOD_S = 0.1


def load() -> ModuleType:
    """Return the script of the documentation."""
    spec = importlib.util.spec_from_file_location("berry_picker", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Berry:
    """Speaks ten times a second until ``be_silent`` or the end."""

    def __init__(self, broker: str) -> None:
        self.script = load()
        self.id: str = self.script.ROBOT
        self._picker = self.script.BerryPicker()
        self._link = MqttLink(broker, "berry-picker-test")
        self._silent, self._end = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._speak, daemon=True)

    def __enter__(self) -> Berry:
        self._link.start()
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._end.set()
        self._thread.join(2)
        self._link.publish(topic(self.id, Up.FACTSHEET), b"", qos=1, retain=True)
        self._link.stop()

    def be_silent(self) -> None:
        """Say nothing any more."""
        self._silent.set()

    def speak(self) -> None:
        """Speak again."""
        self._silent.clear()

    def _speak(self) -> None:
        began_s, told_s = time.monotonic(), -10.0
        while not self._end.wait(PERIOD_S):
            now_s = time.monotonic() - began_s
            if self._silent.is_set():
                continue
            if now_s - told_s > 2:
                told_s = now_s
                self._link.publish(topic(self.id, Up.FACTSHEET), self._picker.factsheet(), qos=1, retain=True)
            for kind, payload in self._picker.now(now_s):
                self._link.publish(topic(self.id, kind), payload)
