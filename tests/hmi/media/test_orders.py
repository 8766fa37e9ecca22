"""What a page may ask of its picture."""

from __future__ import annotations

import msgspec
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


def test_whatever_a_robot_may_say_of_its_posture_may_be_asked_for_again() -> None:
    joints = {
        f"joint {number} with a name that is as long as the wire lets it be, which is a lot": 9e5
        for number in range(128)
    }
    said = {
        "lat_deg": -90,
        "lon_deg": 180,
        "theta_rad": 1000,
        "height_m": -1e6,
        "joints": joints,
        "at_ms": 1795390000000,
    }
    order = decode_order(msgspec.json.encode({"k": "replay", **said, "undone": ["t" * 80] * 200}))
    assert isinstance(order, Replay)
    assert (order.theta_rad, order.joints, order.at_ms) == (1000, joints, 1795390000000)


@pytest.mark.parametrize(
    "text",
    [
        "", "[]", "null", '{"k":"farm"}', '{"k":"view","view":"inside"}',
        '{"k":"layer","name":"/machine","on":true}',
        '{"k":"replay","lat_deg":NaN,"lon_deg":5,"theta_rad":1}',
        '{"k":"replay","lat_deg":95,"lon_deg":5,"theta_rad":1}',
        '{"k":"lift","height_m":-1}', '{"k":"lift","height_m":NaN}',
        '{"k":"zoom","by":1e9}', '{"k":"view","view":"top"}' + " " * 70_000,
    ],
)  # fmt: skip
def test_everything_else_is_refused(text: str) -> None:
    with pytest.raises(BadOrder):
        decode_order(text)
