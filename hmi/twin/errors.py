"""What can be wrong with a robot model, each one sentence for the person who uploaded it.

ModelError
└── UnsafeModel      it names something outside its folder, or is built to do harm
"""

from __future__ import annotations


class ModelError(Exception):
    """The model cannot be used; the message names the file or link and says what to do."""


class UnsafeModel(ModelError):
    """The model reaches out of its folder or is built to exhaust the reader."""
