"""What a robot writes to its disk and finds there after a reboot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from backend_clients.simulator.latch import LatchMemory, PressRecord
from backend_clients.simulator.mission_run import MissionRun
from backend_clients.simulator.route import RouteError
from backend_clients.simulator.state_folder import SavedProgress, SavedSafety, StateFolder

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain

SAVE_EVERY_S = 1.0


class Memory:
    """Keeps one brain's latch, fence, mission and progress in a state folder."""

    def __init__(self, store: StateFolder) -> None:
        self._store = store
        self._kept_token = 0
        self._saved_s = 0.0

    def load_safety(self, boot: str) -> SavedSafety:
        """Return what was saved; a file that cannot be read latches, for it may have held a STOP."""
        try:
            saved = self._store.load_safety() or SavedSafety(latch=LatchMemory())
        except ValueError:
            lost = PressRecord(stop_id=f"unreadable-{boot[:16]}", by="robot", device="disk", pressed_s=0.0)
            saved = SavedSafety(latch=LatchMemory(presses=[lost]))
        self._kept_token = saved.lease_token
        return saved

    def load_progress(self, brain: Brain) -> None:
        """Give the brain the mission it had, paused, with its progress."""
        mission, saved = self._store.load_mission(), self._store.load_progress()
        if mission is None:
            return
        try:
            brain.run = MissionRun(mission, brain.frame, (brain.config.x_m, brain.config.y_m), brain.profile)
        except RouteError as error:
            brain.journal.log(0, f"stored mission dropped: {error}")
            return
        if saved is not None:
            brain.run.restore(saved)

    def save_mission(self, run: MissionRun) -> None:
        """Write the mission."""
        self._store.save_mission(run.mission)

    def save_safety(self, brain: Brain) -> None:
        """Write latch and lease fence."""
        saved = SavedSafety(
            latch=brain.latch.memory(),
            lease_token=brain.guard.lease_token,
            revoked_token=brain.guard.revoked_token,
        )
        self._store.save_safety(saved)
        self._kept_token = saved.lease_token

    def keep_fence(self, brain: Brain) -> None:
        """Write the lease fence if a newer token was seen; it has to hold after a reboot."""
        if brain.guard.lease_token != self._kept_token:
            self.save_safety(brain)

    def save(self, brain: Brain) -> None:
        """Write place and progress."""
        base = brain.machine.base
        saved = SavedProgress(x_m=base.x_m, y_m=base.y_m, theta_rad=base.theta_rad, soc=brain.machine.soc)
        if brain.run is not None:
            brain.run.save_into(saved)
        self._store.save_progress(saved)
        self._saved_s = brain.clock.mono_s()

    def save_sometimes(self, brain: Brain) -> None:
        """Write place and progress once a second while it moves."""
        if not brain.machine.base.is_still and brain.clock.mono_s() - self._saved_s >= SAVE_EVERY_S:
            self.save(brain)
