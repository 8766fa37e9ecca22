"""Did all robots fall silent at the same moment? Then it is the network, and one alarm says so, not a thousand."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from hmi.domain.alarm.finding import NOTHING, Finding, Findings

LEAST = 3  # two robots can lose their link at the same moment by chance
TOGETHER_S = 5.0
FALLEN_SHARE, BACK_SHARE = 0.8, 0.5


class AllSilent:
    """Watches who is heard; ask it before robots are judged one by one.

    Args:
        is_online: whether a robot is heard now.
        said_goodbye: whether it told that it was shut down.
    """

    def __init__(
        self, is_online: Callable[[str], bool], said_goodbye: Callable[[str], bool] = lambda _robot_id: False
    ) -> None:
        self._is_online, self._said_goodbye = is_online, said_goodbye
        self._online: set[str] = set()
        self._fell: dict[str, float] = {}
        self._lost: set[str] = set()
        self._since_s = 0.0

    def look(self, robots: Iterable[str], now_s: float) -> Findings:
        """Return the finding while most of those that fell silent together are not back."""
        online = {one for one in robots if self._is_online(one)}
        self._fell = {one: at for one, at in self._fell.items() if now_s - at < TOGETHER_S and one not in online}
        fallen = (one for one in self._online - online if not self._said_goodbye(one))
        self._fell.update(dict.fromkeys(fallen, now_s))
        self._online = online
        if self._lost:
            self._lost |= self._fell.keys()
            if len(self._lost & online) >= BACK_SHARE * len(self._lost):
                self._lost = set()
        elif len(self._fell) >= LEAST and len(self._fell) >= FALLEN_SHARE * (len(self._fell) + len(online)):
            self._lost, self._since_s = set(self._fell), now_s
        if not self._lost:
            return NOTHING
        silent = len(self._lost - online)
        return (Finding("all-silent", f"{silent} robots fell silent together.", since_s=self._since_s),)
