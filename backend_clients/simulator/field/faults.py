"""What can go wrong with a field station, for testers and for the demo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, TypeVar

import msgspec
from msgspec import Meta, Struct

from backend_clients.field.messages import Kind
from backend_clients.simulator.field.instrument import INSTRUMENTS
from backend_clients.simulator.field.station import Key, Sample

Share = Annotated[float, Meta(ge=0, le=1)]
Which = Annotated[str, Meta(max_length=64)]
T = TypeVar("T", bound=Struct)
MEASURING: tuple[Kind, ...] = ("weather", "soil", "respiration")
EVERY: tuple[Kind, ...] = (*MEASURING, "camera")
HOUR_S = 3600.0


class Silence(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="silence", tag_field="fault"):
    """It says and hears nothing."""


class Drift(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="drift", tag_field="fault"):
    """A value, or all of them if ``quantity`` is empty, goes away from the truth by so much of its span an hour."""

    quantity: Which = ""
    share_per_h: Annotated[float, Meta(ge=-10, le=10)] = 0.5


class Stuck(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="stuck", tag_field="fault"):
    """A value, or all of them, stays as it was read first with this fault."""

    quantity: Which = ""


class LowBattery(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="low-battery", tag_field="fault"):
    """The battery is at ``level``."""

    level: Share = 0.09


class ClockSkew(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="clock-skew", tag_field="fault"):
    """Its clock is ahead by ``offset_s``, behind if negative."""

    offset_s: Annotated[float, Meta(ge=-1e8, le=1e8)] = 2700.0


class Duplicates(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="duplicates", tag_field="fault"):
    """It sends everything it measured ``copies`` times more."""

    copies: Annotated[int, Meta(ge=1, le=10)] = 1


class OutOfOrder(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag="out-of-order", tag_field="fault"):
    """Of each two messages with data the second goes first."""


Fault = Silence | Drift | Stuck | LowBattery | ClockSkew | Duplicates | OutOfOrder
_decoder: msgspec.json.Decoder[Fault] = msgspec.json.Decoder(Fault)


def decode_fault(payload: bytes) -> Fault:
    """Return the fault described, e.g. ``{"fault": "drift", "quantity": "co2"}``; raises ``msgspec.DecodeError``."""
    fault = _decoder.decode(payload)
    if isinstance(fault, Drift | Stuck) and fault.quantity and fault.quantity not in INSTRUMENTS:
        raise msgspec.ValidationError(f"there is no quantity {fault.quantity!r}; use {', '.join(INSTRUMENTS)}")
    return fault


def name_of(fault: Fault) -> str:
    """Return the name a fault is switched by."""
    return str(type(fault).__struct_config__.tag)


class Faults:
    """The faults of one station, at most one of a kind."""

    def __init__(self) -> None:
        self._active: dict[str, tuple[Fault, float]] = {}
        self._frozen: dict[Key, float] = {}

    def set(self, fault: Fault, now_s: float) -> None:
        """Switch a fault on, replacing one of its kind."""
        self._active[name_of(fault)] = (fault, now_s)
        if isinstance(fault, Stuck):
            self._frozen.clear()

    def clear(self, name: str | None = None) -> None:
        """Switch one fault, or all, off."""
        for one in [name] if name is not None else list(self._active):
            self._active.pop(one, None)

    def list(self) -> list[Fault]:
        """Return the active faults."""
        return [fault for fault, _ in self._active.values()]

    def of(self, kind: type[T]) -> T | None:
        """Return the active fault of a kind."""
        fault, _ = self._active.get(str(kind.__struct_config__.tag), (None, 0.0))
        return fault if isinstance(fault, kind) else None

    def applied(self, samples: list[Sample], now_s: float) -> list[Sample]:
        """Return what a station with these faults reads instead; still within the range of its instruments."""
        return [self._one(sample, now_s) for sample in samples]

    def _one(self, sample: Sample, now_s: float) -> Sample:
        instrument, value = INSTRUMENTS[sample.quantity], sample.value
        stuck, drift = self.of(Stuck), self.of(Drift)
        if stuck is not None and stuck.quantity in ("", sample.quantity):
            value = self._frozen.setdefault(sample[:2], value)
        if drift is not None and drift.quantity in ("", sample.quantity):
            hours = (now_s - self._active["drift"][1]) / HOUR_S
            value += drift.share_per_h * instrument.span * hours
        return sample._replace(value=instrument.read(value))


@dataclass(frozen=True, slots=True)
class Situation:
    """Something that can be played on a station; ``kinds`` are the stations to which it can happen."""

    id: str
    title: str
    text: str
    kinds: tuple[Kind, ...]
    fault: Fault


SITUATIONS = (
    Situation("sensor-silent", "No radio", "Nothing is heard of it, and it hears nothing.", EVERY, Silence()),
    Situation("sensor-battery", "Low battery", "Its battery is at 9 %; it goes on.", EVERY, LowBattery()),
    Situation(
        "sensor-drift", "Values drift",
        "Its values go away from the truth, half their usual range an hour.", MEASURING, Drift(),
    ),
    Situation("sensor-stuck", "Values stand still", "It sends the same values again and again.", MEASURING, Stuck()),
    Situation(
        "sensor-clock", "A clock is wrong",
        "Its clock is 45 min ahead: it refuses notices and triggers, and its values seem to come from the future.",
        EVERY, ClockSkew(),
    ),
    Situation("sensor-twice", "Everything twice", "Each message comes twice.", EVERY, Duplicates()),
    Situation("sensor-late", "Messages in the wrong order", "Every other message comes late.", MEASURING, OutOfOrder()),
)  # fmt: skip
BY_ID = {one.id: one for one in SITUATIONS}
