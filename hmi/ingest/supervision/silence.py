"""Did all robots fall silent at the same moment? Then it is the network, and one alarm says so, not a thousand."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable

from hmi.domain.alarm.finding import NOTHING, Finding, Findings

LEAST = 3  # two robots can lose their link at the same moment by chance
TOGETHER_S = 5.0
SETTLED_S = 60.0  # a failing network has taken its robots within a minute; later losses have reasons of their own
FALLEN_SHARE = 0.8


class AllSilent:
    """Watches who is heard; ask it before robots are judged one by one.

    While it finds something nobody is told of single lost links, so it ends as soon as that explains too little.

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
        """Return the finding while those that fell silent together and stayed so are most of the fleet in use."""
        known = set(robots)
        online = {one for one in known if self._is_online(one)}
        fallen = {one for one in (self._online & known) - online if not self._said_goodbye(one)}
        self._online = online
        self._fell = {
            one: at for one, at in self._fell.items() if now_s - at < TOGETHER_S and one in known and one not in online
        }
        self._fell.update(dict.fromkeys(fallen, now_s))
        self._lost = (self._lost & known) - online
        if self._lost and not self._explains(fallen, online, now_s):
            self._lost = set()
        if not self._lost and len(self._fell) >= LEAST and _is_most(self._fell, online):
            self._lost, self._since_s = set(self._fell), now_s
        if not self._lost:
            return NOTHING
        return (Finding("all-silent", f"{len(self._lost)} robots fell silent together.", since_s=self._since_s),)

    def _explains(self, fallen: set[str], online: set[str], now_s: float) -> bool:
        """Take in who fell silent just now; return whether it is still one cause."""
        if now_s - self._since_s < SETTLED_S:
            self._lost |= fallen
        elif fallen:
            return False
        return _is_most(self._lost, online)


def _is_most(fallen: Collection[str], online: Collection[str]) -> bool:
    return len(fallen) >= FALLEN_SHARE * (len(fallen) + len(online))
