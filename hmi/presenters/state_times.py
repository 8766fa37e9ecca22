"""Stays in states and what they add up to, as REST carries them; a table to take away."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime, timedelta
from typing import Any

from hmi.domain.state_chart import Chart
from hmi.domain.state_share import Sums, resting
from hmi.domain.state_times import Interval
from hmi.presenters.alarms import epoch_ms
from hmi.presenters.units import milliseconds

MOST_SHOWN = 4000  # more bars than a screen has places for; sums are of all
COLUMNS = ("start_utc", "end_utc", "seconds", "state", "label", "subsystem", "path", "result", "is_guessed")
LABELS = {"": "Other"}
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
_AT_ONCE = timedelta(seconds=1)


def state_times(
    stays: Sequence[Interval],
    sums: Sums,
    chart: Chart | None,
    span: tuple[datetime, datetime],
    now: tuple[datetime, float],
) -> dict[str, Any]:
    """Return stays of innermost states in a span, with sums by subsystem and by state.

    Args:
        now: one moment by the wall clock and by the console's own (monotonic seconds). With it a browser puts what
            the lane tells beside what is on record, whatever its own clock says.
    """
    start, end = span
    inside = [one for one in stays if one.is_leaf and one.start <= end and (one.end is None or one.end >= start)]
    shown = inside
    if len(inside) > MOST_SHOWN:
        shown = sorted(inside, key=lambda one: -one.seconds(start, end))[:MOST_SHOWN]
        shown.sort(key=lambda one: one.start)
    normal = {one.id: one.normal_s for one in chart.states} if chart else {}
    lanes = _lanes(chart)
    return {
        "from": epoch_ms(start),
        "to": epoch_ms(end),
        "now": epoch_ms(now[0]),
        "now_m": milliseconds(now[1]),
        "intervals": [_interval(one, normal.get(one.state), lanes) for one in shown],
        "is_thinned": len(shown) < len(inside),
        "stays": len(inside),
        "share": [
            {"subsystem": one.subsystem, "label": LABELS.get(one.subsystem, one.subsystem), "s": round(one.seconds, 3),
             "share": round(one.share, 5)}
            for one in sums.shares
        ],
        "per_state": [
            {"state": one.state, "label": one.label, "subsystem": one.subsystem, "count": one.count,
             "total_s": round(one.total_s, 3), "mean_s": _short(one.mean_s), "longest_s": _short(one.longest_s),
             "normal_s": one.normal_s, "drift": _short(one.drift), "is_drifting": one.is_drifting}
            for one in sums.states
        ],
        "resting": sorted(resting(chart)),
        "total_s": round(sums.total_s, 3),
        "wall_s": round(sums.wall_s, 3),
    }  # fmt: skip


def transitions(stays: Sequence[Interval], chart: Chart | None, most: int) -> list[dict[str, Any]]:
    """Return the newest changes of state with cause and result, newest first.

    A change is a stay that begins where another of the same parent ended. The cause is what the chart names for it.
    """
    causes: dict[tuple[str, str], list[str]] = {}
    for move in chart.transitions if chart else ():
        causes.setdefault((move.source, move.target), []).append(move.event)
    before: dict[tuple[str, ...], Interval] = {}
    found = []
    for one in sorted(stays, key=lambda one: one.start):
        group = one.path[:-1] if one.state != " > ".join(one.path) else ()
        last = before.get(group)
        before[group] = one
        if (
            last is None
            or last.end is None
            or abs(one.start - last.end) > _AT_ONCE
            or _is_again(last, one, causes)
            or _is_region(one, chart)
        ):
            continue
        found.append(
            {
                "at": epoch_ms(one.start),
                "source": last.state,
                "source_label": last.label,
                "target": one.state,
                "target_label": one.label,
                "event": " or ".join(dict.fromkeys(causes.get((last.state, one.state), ()))),
                "result": last.result,
                "duration_s": None if last.is_guessed else round((last.end - last.start).total_seconds(), 3),
            }
        )
    return found[::-1][:most]


def table(stays: Iterable[Interval]) -> str:
    """Return stays of innermost states as CSV; what a spreadsheet would take for a formula is kept as words."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\r\n")
    writer.writerow(COLUMNS)
    for one in stays:
        if not one.is_leaf:
            continue
        end = "" if one.end is None else one.end.isoformat(timespec="milliseconds")
        seconds = "" if one.end is None else f"{(one.end - one.start).total_seconds():.3f}"
        row = (one.start.isoformat(timespec="milliseconds"), end, seconds, one.state, one.label, one.subsystem,
               " > ".join(one.path), one.result, "yes" if one.is_guessed else "")  # fmt: skip
        writer.writerow([_plain(value) for value in row])
    return out.getvalue()


def _interval(one: Interval, normal_s: float | None, lanes: dict[str, str]) -> dict[str, Any]:
    return {
        "state": one.state,
        "label": one.label,
        "subsystem": one.subsystem,
        "lane": lanes.get(one.state, one.subsystem),
        "path": list(one.path),
        "start": epoch_ms(one.start),
        "end": epoch_ms(one.end),
        "result": one.result,
        "normal_s": normal_s,
        "is_guessed": one.is_guessed,
    }


def _lanes(chart: Chart | None) -> dict[str, str]:
    """Return the row each state is drawn in: its region, and outside of regions its subsystem."""
    if chart is None:
        return {}
    states = {one.id: one for one in chart.states}
    lanes = {}
    for one in chart.states:
        lanes[one.id] = one.subsystem
        at = one
        for _ in chart.states:
            if at.parent is None or at.parent not in states:
                break
            at = states[at.parent]
            if at.kind == "region":
                lanes[one.id] = at.label
                break
    return lanes


def _is_again(last: Interval, one: Interval, causes: Mapping[tuple[str, str], list[str]]) -> bool:
    """Say whether it is the same state, only because what holds it was entered anew."""
    return last.state == one.state and (last.state, one.state) not in causes


def _is_region(one: Interval, chart: Chart | None) -> bool:
    return chart is not None and any(state.id == one.state and state.kind == "region" for state in chart.states)


def _short(value: float | None) -> float | None:
    return None if value is None else round(value, 4)


def _plain(text: str) -> str:
    return f"'{text}" if text.startswith(_FORMULA) else text
