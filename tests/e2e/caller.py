"""Somebody who uses the console without a browser: REST with a session, and ticks from the live lane."""

from __future__ import annotations

import json
import secrets
from typing import Any

import httpx
from websockets.sync.client import ClientConnection, connect


class Caller:
    """One signed-in session of a demo account."""

    def __init__(self, url: str, name: str) -> None:
        self.url = url
        self._client = httpx.Client(base_url=url, timeout=10, trust_env=False)
        answer = self._client.post("/api/v1/session", json={"name": name, "password": name})
        answer.raise_for_status()
        self.signed_in: dict[str, Any] = answer.json()
        self._client.headers["X-Headland-CSRF"] = self.signed_in["csrf"]
        self._lane: ClientConnection | None = None

    def close(self) -> None:
        """Close the lane and sign out."""
        if self._lane is not None:
            self._lane.close()
        self._client.delete("/api/v1/session")
        self._client.close()

    def get(self, path: str) -> Any:
        """Return the JSON of a GET below ``/api/v1``."""
        answer = self._client.get(f"/api/v1{path}")
        answer.raise_for_status()
        return answer.json()

    def post(self, path: str, body: dict[str, Any]) -> httpx.Response:
        """Send a POST below ``/api/v1``; a fresh tick is added where the body has ``tick: None``."""
        if body.get("tick", "") is None:
            body = {**body, "tick": self.tick()}
        return self._client.post(f"/api/v1{path}", json=body)

    def patch(self, path: str, body: dict[str, Any]) -> httpx.Response:
        """Send a PATCH below ``/api/v1``."""
        return self._client.patch(f"/api/v1{path}", json=body)

    def delete(self, path: str) -> httpx.Response:
        """Send a DELETE below ``/api/v1``."""
        return self._client.delete(f"/api/v1{path}")

    def tick(self) -> str:
        """Return a tick issued just now."""
        if self._lane is None:
            cookies = "; ".join(f"{c.name}={c.value}" for c in self._client.cookies.jar)
            self._lane = connect(
                self.url.replace("http", "ws", 1) + "/live",
                origin=self.url,  # type: ignore[arg-type]
                additional_headers={"Cookie": cookies},
                compression=None,
            )
        newest = ""
        while True:
            try:
                frame = self._lane.recv(timeout=2 if not newest else 0.001)
            except TimeoutError:
                return newest
            if isinstance(frame, str) and (read := json.loads(frame)).get("k") == "tick":
                newest = read["id"]

    def command(self, robot: str, action: str, **more: Any) -> dict[str, Any]:
        """Send a command; return the answer, whatever it is."""
        body = {"command_id": secrets.token_hex(16), "action": action, "tick": None, **more}
        answer: dict[str, Any] = self.post(f"/robots/{robot}/commands", body).json()
        return answer

    def stop(self, *robots: str) -> dict[str, Any]:
        """Press STOP by the console's REST."""
        answer = self.post("/stop", {"stop_id": secrets.token_hex(16), "robots": list(robots)})
        answer.raise_for_status()
        said: dict[str, Any] = answer.json()
        return said

    def calm(self, robot: str) -> None:
        """Reset every press on a robot, end its mission and give its control back."""
        now = self.get(f"/robots/{robot}")
        open_presses = [p["stop_id"] for p in (now.get("safety") or {}).get("presses", []) if not p["is_reset"]]
        busy = (now.get("mission") or {}).get("status") in ("running", "paused")
        is_driven = (now.get("mode") or {}).get("mode") == "manual"
        if open_presses or busy or is_driven or (now.get("lease") or {}).get("owner"):
            self.post(f"/robots/{robot}/lease", {"op": "take", "tick": None, "reason": "end of a test"})
        if open_presses:
            body = {"reset_id": secrets.token_hex(16), "stop_ids": open_presses, "reason": "Test", "tick": None}
            self.post(f"/robots/{robot}/stop-reset", body).raise_for_status()
        if is_driven:
            self.command(robot, "drive_close")
        if busy:
            self.command(robot, "abort")
        self.post(f"/robots/{robot}/lease", {"op": "release", "tick": None})

    def thaw(self) -> None:
        """Release the queue if a STOP ALL froze it, which outlasts the reset of the robots."""
        if self.get("/queue")["frozen"]:
            self.post("/queue/release", {"reason": "end of a test", "tick": None}).raise_for_status()
