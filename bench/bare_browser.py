"""A browser that nobody looks over the shoulder of, for figures of its main thread.

A test driver listens to everything: each frame of a websocket is copied to it by the page's main thread. Here only
the few questions of a bench go over the DevTools connection.
"""

from __future__ import annotations

import itertools
import json
import re
import subprocess
import tempfile
import time
from types import TracebackType
from typing import Any

import httpx
from websockets.sync.client import ClientConnection, connect

from tests.find_browser import find_browser

START_S, STEP_S = 30.0, 0.25


class BareBrowser:
    """One page in a Chromium of its own; use it with ``with``.

    Args:
        flags: of the browser.
        size: of the window, px.
    """

    def __init__(self, flags: tuple[str, ...], size: tuple[int, int]) -> None:
        self._flags, self._size = flags, size
        self._numbers = itertools.count(1)

    def __enter__(self) -> BareBrowser:
        path = find_browser()
        if path is None:
            raise RuntimeError("no Chromium found")
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self._process = subprocess.Popen(
            [path, *self._flags, "--headless", "--remote-debugging-port=0", f"--user-data-dir={self._folder.name}",
             f"--window-size={self._size[0]},{self._size[1]}", "about:blank"],
            stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        port = self._port()
        [page] = [one for one in httpx.get(f"http://127.0.0.1:{port}/json").json() if one["type"] == "page"]
        self._connection: ClientConnection = connect(page["webSocketDebuggerUrl"], max_size=None)
        width, height = self._size
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.send("Performance.enable")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._connection.close()
        self._process.terminate()
        self._process.wait(10)
        self._folder.cleanup()

    def _port(self) -> int:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            if found := re.search(r"ws://127\.0\.0\.1:(\d+)/", line):
                return int(found.group(1))
        raise RuntimeError("the browser did not start")

    def send(self, method: str, **params: Any) -> dict[str, Any]:
        """Send one DevTools command and return its result.

        Raises:
            RuntimeError: it was refused.
        """
        number = next(self._numbers)
        self._connection.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            answer = json.loads(self._connection.recv(60.0))
            if answer.get("id") != number:
                continue
            if "error" in answer:
                raise RuntimeError(f"{method}: {answer['error']['message']}")
            result: dict[str, Any] = answer["result"]
            return result

    def open(self, url: str, cookie: tuple[str, str]) -> None:
        """Open an address with a cookie."""
        self.send("Network.setCookie", name=cookie[0], value=cookie[1], url=url)
        self.send("Network.disable")
        self.send("Page.navigate", url=url)

    def evaluate(self, expression: str) -> Any:
        """Return the value of an expression, or of the promise that it is."""
        answer = self.send("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression[:60]}: {answer['exceptionDetails']['text']}")
        return answer["result"].get("value")

    def wait_for(self, expression: str) -> None:
        """Return when an expression is true.

        Raises:
            TimeoutError: it did not become true.
        """
        until_s = time.monotonic() + START_S
        while not self.evaluate(f"Boolean({expression})"):
            if time.monotonic() > until_s:
                raise TimeoutError(expression)
            time.sleep(STEP_S)

    def thread_ms(self) -> float:
        """Return the processor time that the page's main thread has taken."""
        metrics = self.send("Performance.getMetrics")["metrics"]
        return 1000 * next(float(metric["value"]) for metric in metrics if metric["name"] == "ThreadTime")
