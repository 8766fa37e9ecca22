"""The errors of everything that keeps records.

::

    StoreError
    ├── DatabaseUnavailable   cannot be opened or is locked; try again later
    │   └── DatabaseFull      its disk is full; somebody has to make room
    ├── DatabaseTooNew        made by a newer Headland
    ├── AlreadyExists         the id is taken
    ├── NotFound              no such row in this farm
    ├── StopListNotWritten    saved, but the STOP gateway could not be told
    ├── PicturesFull          the disk has no room for pictures
    ├── PicturesBusy          more pictures come than the disk takes
    └── TooMuchMarked         pictures that are marked would leave too little room for others
"""

from __future__ import annotations


class StoreError(Exception):
    """Root of all errors raised by ``hmi.store``."""


class DatabaseUnavailable(StoreError):
    """The database cannot be used now: not reachable, locked, or its disk is full."""


class DatabaseFull(DatabaseUnavailable):
    """The disk of the database is full."""


class DatabaseTooNew(StoreError):
    """The database was written by a newer version of Headland."""


class AlreadyExists(StoreError):
    """The id is taken."""


class NotFound(StoreError):
    """There is no such row in this farm."""


class StopListNotWritten(StoreError):
    """The change is saved, but the STOP gateway's list could not be written: STOP does not know of it yet."""


class PicturesFull(StoreError):
    """The disk has too little room left: nothing more is recorded."""


class PicturesBusy(StoreError):
    """More pictures come in than the disk takes."""


class TooMuchMarked(StoreError):
    """What is marked would leave too little room for what comes."""
