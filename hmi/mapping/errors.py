"""The errors of the map.

::

    MappingError
    ├── BadFeature          what was handed in is no feature of the map
    ├── OperationRefused    the operation does not fit these features or arguments; nothing changed
    └── BadWalk             what was walked makes no outline
"""

from __future__ import annotations


class MappingError(Exception):
    """Root of all errors raised by ``hmi.mapping``.

    Args:
        code: stable machine-readable reason, e.g. ``unknown_kind``.
        text: a sentence for a person: what is wrong and how to mend it.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(f"{code}: {text}")
        self.code = code
        self.text = text

    def __reduce__(self) -> tuple[type[MappingError], tuple[str, ...]]:
        """Survive the way back from a worker process."""
        return type(self), (self.code, self.text)


class BadFeature(MappingError):
    """A feature breaks a rule of the map.

    Args:
        feature_id: which feature, as far as it could be read; else ``None``.
    """

    def __init__(self, code: str, text: str, feature_id: str | None = None) -> None:
        super().__init__(code, text)
        self.feature_id = feature_id

    def __reduce__(self) -> tuple[type[MappingError], tuple[str, ...]]:
        """Survive the way back from a worker process."""
        return type(self), (self.code, self.text, self.feature_id)  # type: ignore[return-value]


class OperationRefused(MappingError):
    """The operation was understood and cannot be done like this."""


class BadWalk(MappingError):
    """The points walked make neither an outline nor a line."""
