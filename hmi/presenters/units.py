"""Numbers and durations as people read them; SI and radians in, text out."""

from __future__ import annotations

import math

MINUS = "−"


def number(value: float, digits: int = 0) -> str:
    """Return a number with fixed decimals and a real minus; never a negative zero."""
    text = f"{abs(value):.{digits}f}"
    is_negative = value < 0 and float(text) != 0
    return MINUS + text if is_negative else text


def heading_deg(theta_rad: float) -> float:
    """Return degrees clockwise from north, 0 to 360, of an ENU yaw."""
    return round((90.0 - math.degrees(theta_rad)) % 360.0, 1) % 360.0


def age_text(age_s: float) -> str:
    """Return an age: ``0.2 s``, ``12 s``, ``2:14``, ``1 h 08``."""
    age_s = max(0.0, age_s)
    if age_s < 9.95:
        return f"{age_s:.1f} s"
    if age_s < 59.5:
        return f"{age_s:.0f} s"
    minutes, seconds = divmod(round(age_s), 60)
    return f"{minutes}:{seconds:02d}" if minutes < 60 else span_text(age_s)


def span_text(span_s: float) -> str:
    """Return a longer duration: ``26 min``, ``3 h 26``."""
    minutes = max(0, round(span_s / 60))
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d}"


def milliseconds(seconds: float | None) -> float | None:
    """Return ms with a tenth, as the lane carries all times."""
    return None if seconds is None else round(seconds * 1000, 1)


def short_length(length_m: float) -> tuple[str, str]:
    """Return text and unit of a small length: centimetres below a metre, millimetres below a decimetre."""
    if abs(length_m) < 1:
        return number(length_m * 100, 1 if abs(length_m) < 0.1 else 0), "cm"
    return number(length_m, 2), "m"


def percent(share: float) -> str:
    """Return a share 0..1 in whole percent; full only when it is full."""
    return number(math.floor(share * 100 + 1e-9))


def on_scale(value: float, low: float, high: float) -> float:
    """Return where ``value`` lies between two ends, 0 to 100, clamped, for a bar."""
    return round(min(100.0, max(0.0, (value - low) / (high - low) * 100)), 1)
