"""What follows the last picture that can be decoded alone: whoever comes late begins with it."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar

MOST_BYTES = 32 * 1024 * 1024


class Coded(Protocol):
    """A picture of a stream."""

    @property
    def data(self) -> bytes:
        """Its bytes."""
        ...

    @property
    def is_key(self) -> bool:
        """Whether it can be decoded alone."""
        ...


T = TypeVar("T", bound=Coded)


class Group(Generic[T]):
    """Bounded: one that grows beyond ``most`` pictures is dropped, and the next key picture begins another."""

    def __init__(self, most: int) -> None:
        self._most, self._size = most, 0
        self.row: list[T] = []

    def add(self, one: T) -> None:
        """Keep the next picture."""
        if one.is_key or self.is_full_for(one):
            self.clear()
        if one.is_key or self.row:
            self.row.append(one)
            self._size += len(one.data)

    def is_full_for(self, one: T) -> bool:
        """Whether one more that is no key picture would be too many."""
        return len(self.row) >= self._most or self._size + len(one.data) > MOST_BYTES

    def clear(self) -> None:
        """Forget them."""
        self.row.clear()
        self._size = 0
