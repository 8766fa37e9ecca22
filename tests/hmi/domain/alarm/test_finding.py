"""Names of robots as parts of alarm ids."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.alarm.finding import MAX_DETAIL, detail_of_id

STYLES = [
    r"[a-z0-9]{1,9}(-[a-z0-9]{1,9}){0,6}",
    r"[A-Z0-9]{1,9}(_[A-Z0-9]{1,9}){0,6}",
    r"[A-Za-z0-9._-]*[.][A-Za-z0-9._-]*",
]


@pytest.mark.parametrize("pair", [("E1.2", "E1-2"), ("Ab", "aB"), ("x" * 41, "x" * 42), ("...", "-.-")])
def test_names_that_shorten_to_the_same_words_stay_apart(pair: tuple[str, str]) -> None:
    assert detail_of_id(pair[0]) != detail_of_id(pair[1])


@pytest.mark.parametrize(
    ("name", "detail"),
    [("laser-driver", "laser-driver"), ("laser_driver", "laser-driver"), ("NOZZLE_7", "nozzle-7"), ("7", "7")],
)
def test_names_in_a_usual_style_keep_their_words(name: str, detail: str) -> None:
    assert detail_of_id(name) == detail


@given(data=st.data())
def test_different_names_of_one_style_stay_different_and_fit(data: st.DataObject) -> None:
    style = st.from_regex(data.draw(st.sampled_from(STYLES)), fullmatch=True).filter(lambda name: len(name) <= 64)
    one, other = data.draw(style), data.draw(style)
    assert len(detail_of_id(one)) <= MAX_DETAIL
    assert set(detail_of_id(one)) <= set("abcdefghijklmnopqrstuvwxyz0123456789-")
    assert (detail_of_id(one) == detail_of_id(other)) == (one == other)
