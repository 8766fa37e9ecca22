"""What a page may ask of its own picture, by the control socket; anything else is refused."""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from hmi.twin.groups import Group
from hmi.twin.moment import Moment
from hmi.twin.viewer import View

MAX_ORDER_BYTES = 64 * 1024  # as much as a robot may say at once: it may be asked for again


class SetView(Struct, frozen=True, tag_field="k", tag="view"):
    """Stand the camera."""

    view: View


class SetLayer(Struct, frozen=True, tag_field="k", tag="layer"):
    """Show or hide one layer."""

    name: Group
    on: bool


class Hold(Struct, frozen=True, tag_field="k", tag="hold"):
    """A person touches the picture, or lets go."""

    on: bool


class Zoom(Struct, frozen=True, tag_field="k", tag="zoom"):
    """Come nearer (below 1) or go back."""

    by: Annotated[float, Meta(ge=0.2, le=5)]


class Replay(Moment, frozen=True, tag_field="k", tag="replay"):
    """Show the robot where it was; needs the right to replay."""


class Live(Struct, frozen=True, tag_field="k", tag="live"):
    """Back to now."""


class Unmark(Struct, frozen=True, tag_field="k", tag="unmark"):
    """Take the mark of the place that was touched away."""


class Lift(Struct, frozen=True, tag_field="k", tag="lift"):
    """Show how high above the touched place the tool would stand."""

    height_m: Annotated[float, Meta(ge=0, le=20)]


class Theme(Struct, frozen=True, tag_field="k", tag="theme"):
    """Dark ground at night."""

    dark: bool


Order = SetView | SetLayer | Hold | Zoom | Replay | Live | Unmark | Lift | Theme
_decoder: msgspec.json.Decoder[Order] = msgspec.json.Decoder(Order)


class BadOrder(Exception):
    """It is none of the orders."""


def decode_order(payload: str | bytes) -> Order:
    """Return an order; raises ``BadOrder``."""
    if len(payload) > MAX_ORDER_BYTES:
        raise BadOrder("too long")
    try:
        order: Order = _decoder.decode(payload)
        return order
    except (msgspec.DecodeError, RecursionError, UnicodeError) as error:
        raise BadOrder(str(error)) from error
