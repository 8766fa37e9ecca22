"""Why a plan could not be made.

::

    PlanningError
    └── PlanRefused     the request cannot be planned; carries a code, a sentence and the field to change
"""

from __future__ import annotations


class PlanningError(Exception):
    """Root of all errors raised by ``hmi.planning``."""


class PlanRefused(PlanningError):
    """The request was understood and cannot be planned.

    Args:
        code: stable machine-readable reason, e.g. ``width_not_positive``.
        text: one sentence for a person: what is wrong and what to change.
        field: name of the input that is wrong, or empty.
    """

    def __init__(self, code: str, text: str, field: str = "") -> None:
        super().__init__(f"{code}: {text}")
        self.code = code
        self.text = text
        self.field = field

    def __reduce__(self) -> tuple[type[PlanRefused], tuple[str, str, str]]:
        """Survive the way back from a worker process."""
        return type(self), (self.code, self.text, self.field)
