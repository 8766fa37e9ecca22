"""How far people must stay away from a machine: one rule for banner, map, twin and the STOP gateway."""

from __future__ import annotations

USUAL_M = 15.0  # safety rules, where neither farm nor machine say more


def keep_out_m(of_farm: float | None, of_machine: float | None) -> float:
    """Return metres: the larger of what an admin set and what the machine's factsheet says.

    A farm may ask for more distance than the machine, never for less.
    """
    return max((one for one in (of_farm, of_machine) if one), default=USUAL_M)
