"""What a page may ask of its picture."""

from __future__ import annotations

import pytest

from hmi.media.orders import BadOrder, Lift, Replay, SetLayer, SetView, decode_order
from hmi.twin.groups import Group
from hmi.twin.viewer import View


def test_orders_are_read() -> None:
    assert decode_order('{"k":"view","view":"top"}') == SetView(View.TOP)
    assert decode_order('{"k":"layer","name":"trees","on":false}') == SetLayer(Group.TREES, False)
    assert decode_order('{"k":"lift","height_m":1.6}') == Lift(1.6)
    said = decode_order('{"k":"replay","lat_deg":52,"lon_deg":5,"theta_rad":1,"joints":{"slew":0.5}}')
    assert said == Replay(52.0, 5.0, 1.0, {"slew": 0.5})


@pytest.mark.parametrize(
    "text",
    [
        "", "[]", "null", '{"k":"farm"}', '{"k":"view","view":"inside"}',
        '{"k":"layer","name":"/machine","on":true}',
        '{"k":"replay","lat_deg":NaN,"lon_deg":5,"theta_rad":1}',
        '{"k":"replay","lat_deg":95,"lon_deg":5,"theta_rad":1}',
        '{"k":"lift","height_m":-1}', '{"k":"lift","height_m":NaN}',
        '{"k":"zoom","by":1e9}', '{"k":"view","view":"top"}' + " " * 20_000,
    ],
)  # fmt: skip
def test_everything_else_is_refused(text: str) -> None:
    with pytest.raises(BadOrder):
        decode_order(text)
