"""What a tester can break in the broker while it runs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field


class Faults(BaseModel):
    """Faults on each request, all off at first.

    Args:
        delay_s: each answer waits that long.
        status: answered instead of the real answer, e.g. 503 or 413; 0 is off.
        times: so many requests are hit, then the faults are over; ``None`` is until switched off.
        methods: only requests with these methods are hit, e.g. ``POST``; none is all.
        takes_effect: with ``status``, the request is done all the same, as when a proxy loses the answer.
        half_open: takes the request and never answers; ``takes_effect`` holds here too.
        cut: sends only so many bytes of an answer's body, then the connection breaks.
        wrong_tenant: serves every request from this tenant instead of its own.
        max_body: largest body it takes, bytes; Orion's own limit is 1,048,576.
        token: only requests with this bearer token are let in; empty is everybody.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    delay_s: Annotated[float, Field(ge=0, le=600)] = 0.0
    status: Annotated[int, Field(ge=0, le=599)] = 0
    times: Annotated[int | None, Field(ge=1)] = None
    methods: tuple[str, ...] = ()
    takes_effect: bool = False
    half_open: bool = False
    cut: Annotated[int | None, Field(ge=0)] = None
    wrong_tenant: str | None = None
    max_body: Annotated[int, Field(ge=0)] = 1_048_576
    token: str = ""


@dataclass(slots=True)
class FaultSwitch:
    """The faults in force; requests ask it once each."""

    faults: Faults = field(default_factory=Faults)
    hits: int = 0

    def set(self, faults: Faults) -> None:
        """Put other faults in force."""
        self.faults, self.hits = faults, 0

    def next(self, method: str) -> Faults:
        """Return the faults for one request."""
        limit, methods = self.faults.times, self.faults.methods
        if (limit is not None and self.hits >= limit) or (methods and method not in methods):
            return Faults(max_body=self.faults.max_body, token=self.faults.token)
        self.hits += 1
        return self.faults
