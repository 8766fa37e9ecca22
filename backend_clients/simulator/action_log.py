"""What became of the newest commands, as reported in the state message."""

from __future__ import annotations

from collections import deque
from typing import Literal

from msgspec.structs import replace

from backend_clients.edge.messages_up import ActionState

MAX_ACTIONS = 8
Ending = Literal["finished", "failed"]


class ActionLog:
    """The newest commands; at most one of them is running."""

    def __init__(self) -> None:
        self._actions: deque[ActionState] = deque(maxlen=MAX_ACTIONS)

    def add(self, command_id: str, action: str, status: Literal["running", "finished", "failed"], text: str) -> None:
        """Note a command; a new running one ends the one before it."""
        if status == "running":
            self.close("finished")
        self._actions.append(ActionState(command_id=command_id, action=action, status=status, text=text))

    def close(self, status: Ending, text: str = "") -> None:
        """End the running command."""
        for i, action in enumerate(self._actions):
            if action.status == "running":
                self._actions[i] = replace(action, status=status, text=text or action.text)

    def list(self) -> list[ActionState]:
        """Return them, oldest first."""
        return list(self._actions)
