"""The robot's latched STOP: set by a press, cleared only by a reset of that press; pure.

A STOP is valid at any age and from anyone. What was reset is remembered, so that a late copy of a
press that people have dealt with cannot latch the machine again.
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct, field

from backend_clients.simulator.verdict import OK, Verdict, accepted, refused

MAX_PRESSES = 1000  # more are acknowledged and stop again, but add nothing to a latch that is set
MAX_RESET_IDS = 2000


class PressRecord(Struct, kw_only=True):
    """One press; ``pressed_s`` is the robot's monotonic time of this boot, negative for an older one."""

    stop_id: str
    by: str
    device: str
    pressed_s: float
    is_reset: bool = False


class LatchMemory(Struct, kw_only=True):
    """What has to survive a reboot."""

    presses: list[PressRecord] = field(default_factory=list)
    reset_ids: list[str] = field(default_factory=list)


class Latch:
    """The set of open presses; the machine may not move while there is one."""

    def __init__(self, memory: LatchMemory | None = None) -> None:
        self._memory = memory or LatchMemory()
        self._reset_ids = dict.fromkeys(self._memory.reset_ids)

    @property
    def is_set(self) -> bool:
        """Whether at least one press is not yet reset."""
        return any(not press.is_reset for press in self._memory.presses)

    @property
    def presses(self) -> Sequence[PressRecord]:
        """The presses of the present latch, those already reset included."""
        return self._memory.presses

    def memory(self) -> LatchMemory:
        """Return what has to be written to disk."""
        self._memory.reset_ids = list(self._reset_ids)
        return self._memory

    def press(self, stop_id: str, by: str, device: str, now_s: float) -> Verdict:
        """Latch one press. Only code ``ok`` is a new one; every answer is an acceptance."""
        if stop_id in self._reset_ids:
            return accepted("already_reset", "This STOP was reset before; it does not stop again.")
        if any(press.stop_id == stop_id for press in self._memory.presses):
            return accepted("already_latched", "The robot has this STOP already and stays stopped.")
        if len(self._memory.presses) < MAX_PRESSES:
            self._memory.presses.append(PressRecord(stop_id=stop_id, by=by, device=device, pressed_s=now_s))
        return OK

    def judge_reset(self, stop_ids: Sequence[str], *, is_standing: bool, is_hardware_stop: bool) -> Verdict:
        """Say whether a reset of ``stop_ids`` may be done now; changes nothing."""
        if is_hardware_stop:
            return refused("hardware_stop")
        if not is_standing:
            return refused("not_standing")
        known = {press.stop_id for press in self._memory.presses} | set(self._reset_ids)
        if not known.intersection(stop_ids):
            return refused("unknown_stop")
        return OK

    def reset(self, stop_ids: Sequence[str]) -> Verdict:
        """Clear exactly the presses named; ids the robot never had are left alone."""
        named, cleared = set(stop_ids), 0
        for press in self._memory.presses:
            if press.stop_id in named and not press.is_reset:
                press.is_reset = True
                self._reset_ids[press.stop_id] = None
                cleared += 1
        while len(self._reset_ids) > MAX_RESET_IDS:
            del self._reset_ids[next(iter(self._reset_ids))]
        waiting = sum(not press.is_reset for press in self._memory.presses)
        if not waiting:
            self._memory.presses.clear()
        if not cleared:
            return accepted("already_reset", "This STOP was reset before.")
        if waiting:
            return accepted("still_latched", f"{waiting} more STOP must be reset before it may move.")
        return OK
