"""The outermost states every family has, and how one leads to another."""

from __future__ import annotations

from typing import TYPE_CHECKING

from backend_clients.edge.machine import ChartState, ChartTransition

if TYPE_CHECKING:
    from backend_clients.simulator.brain import Brain

MOVES: tuple[tuple[str, str, str, str], ...] = (
    ("start-up", "idle", "ready", "self test passed"),
    ("start-up", "paused", "ready", "a mission was interrupted"),
    ("start-up", "stopped", "ready", "a STOP is latched"),
    ("start-up", "fault", "ready", "no energy"),
    ("idle", "mission", "start", "in control, nothing to wait for"),
    ("paused", "mission", "resume", "moved less than 0.2 m"),
    ("mission", "paused", "pause", ""),
    ("mission", "idle", "end", ""),
    ("paused", "idle", "abort", ""),
    ("idle", "paused", "take up", "a mission to go on with"),
    ("idle", "manual", "drive by hand", "in control"),
    ("paused", "manual", "drive by hand", "in control"),
    ("mission", "manual", "drive by hand", "in control"),
    ("manual", "idle", "end by hand", "no mission"),
    ("manual", "paused", "end by hand", "a mission is paused"),
    ("idle", "return-home", "go home", "in control"),
    ("paused", "return-home", "go home", "in control"),
    ("mission", "return-home", "go home", ""),
    ("return-home", "idle", "arrived", "no mission"),
    ("return-home", "paused", "arrived", "a mission is paused"),
    ("return-home", "manual", "drive by hand", "in control"),
    ("idle", "go-to", "go to a place", "in control"),
    ("paused", "go-to", "go to a place", "in control"),
    ("go-to", "idle", "arrived", "no mission"),
    ("go-to", "paused", "arrived", "a mission is paused"),
    ("go-to", "manual", "drive by hand", "in control"),
    *((source, "stopped", "STOP", "") for source in ("idle", "mission", "paused", "manual", "return-home", "go-to")),
    ("stopped", "idle", "reset", "standstill, every press reset"),
    ("stopped", "paused", "reset", "standstill, every press reset"),
    ("fault", "stopped", "STOP", ""),
    *((source, "fault", "no energy", "") for source in ("idle", "mission", "paused", "manual", "return-home", "go-to")),
    ("stopped", "fault", "no energy", ""),
    ("fault", "idle", "mended", "no mission"),
    ("fault", "paused", "mended", "a mission is paused"),
)
"""Source, target, event, guard."""


def top_states(mission: str = "composite") -> list[ChartState]:
    """Return the outermost states; what happens inside ``mission`` is the family's own."""
    return [
        ChartState(
            id="start-up",
            label="Start-up",
            is_initial=True,
            subsystem="Waiting",
            entry=["self test", "read the latch from disk"],
        ),
        ChartState(id="idle", label="Idle", subsystem="Waiting"),
        ChartState(id="mission", label="Mission", kind=mission, exit=["tool off", "save progress"]),  # type: ignore[arg-type]
        ChartState(id="paused", label="Paused", subsystem="Operator", entry=["brake", "tool off", "keep progress"]),
        ChartState(
            id="manual",
            label="Manual",
            subsystem="Operator",
            entry=["tool off", "wait for setpoints"],
            exit=["brake"],
        ),
        ChartState(
            id="stopped",
            label="Stopped",
            subsystem="Operator",
            entry=["brake", "tool off", "write the latch to disk", "revoke control"],
        ),
        ChartState(id="fault", label="Fault", subsystem="Waiting", entry=["brake", "tool off"]),
        ChartState(id="return-home", label="Return home", subsystem="Drive", entry=["horn 3 s"], exit=["brake"]),
        ChartState(id="go-to", label="Go to a place", subsystem="Drive", entry=["horn 3 s"], exit=["brake"]),
    ]


def top_transitions() -> list[ChartTransition]:
    """Return the transitions between the outermost states."""
    return [ChartTransition(source=a, target=b, event=event, guard=guard) for a, b, event, guard in MOVES]


def top_of(brain: Brain) -> str:
    """Return which of the outermost states a robot is in."""
    mode = brain.mode
    if mode == "auto":
        return brain.errand or "mission"
    return str(mode)
