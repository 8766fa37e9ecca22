"""One number on a screen: value, unit, age, bar and a line of meaning."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hmi.presenters.units import milliseconds

Tile = dict[str, Any]
FAST_MS, RTT_MS = 100, 1000  # periods that the streams declare: telemetry 10 Hz, round trip 1 Hz
NOT_HEARD = "nothing heard yet"


def tile(
    key: str,
    label: str,
    kind: str,
    t_s: float | None,
    *,
    value: float | str | None = None,
    text: str = "",
    unit: str = "",
    sub: str = "",
    bar: dict[str, Any] | None = None,
    level: int | None = None,
    period_ms: int = FAST_MS,
    missing: str | None = None,
) -> Tile:
    """Return a tile; ``missing`` says why there is no value, ``level`` is the priority at which it is outside."""
    return {
        "key": key,
        "label": label,
        "value": value,
        "kind": kind,
        "text": text or "––",
        "unit": unit,
        "sub": sub,
        "bar": bar,
        "level": level,
        "t": milliseconds(t_s),
        "period_ms": period_ms,
        "missing": missing,
    }


def bar(low: float, high: float, pointer: float, limits: Sequence[float] = ()) -> dict[str, Any]:
    """Return a bar in percent of its length: the normal band, the pointer, the limits."""
    return {"ok": [low, high], "ptr": pointer, "limits": list(limits)}
