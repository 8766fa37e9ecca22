"""The log a robot keeps of itself, and the port it is read through."""

from __future__ import annotations

from typing import Protocol

MAX_LINES = 2000  # what a robot keeps at least


class LogFailed(Exception):
    """A robot's log could not be read; the adapter translates its client's errors into this.

    Args:
        code: ``no_address``, ``no_answer`` or the robot's own code.
        text: one sentence for a person.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(f"{code}: {text}")
        self.code, self.text = code, text


class LogSource(Protocol):
    """Reads logs from robots."""

    async def tail_log(self, robot_id: str, lines: int) -> list[str]:
        """Return the last lines of a robot's log, oldest first.

        Raises:
            LogFailed: it has no address, does not answer, or refuses.
        """
        ...


def search(lines: list[str], *, words: str = "", node: str = "") -> list[str]:
    """Return the lines that hold ``words`` in any case, and name the node as a word of its own."""
    wanted, name = words.casefold(), node.casefold()
    return [line for line in lines if wanted in line.casefold() and (not name or _names(line.casefold(), name))]


def _names(line: str, name: str) -> bool:
    at = line.find(name)
    while at >= 0:
        before, after = line[at - 1 : at] if at else "", line[at + len(name) : at + len(name) + 1]
        if not (_is_part(before) or _is_part(after)):
            return True
        at = line.find(name, at + 1)
    return False


def _is_part(char: str) -> bool:
    return char.isalnum() or char in ("_", "-") if char else False
