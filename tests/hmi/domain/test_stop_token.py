"""The token that lets a browser press STOP."""

from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.stop_token import BadStopToken, StopToken

SECRET = "a-secret-of-this-farm"
MARTHA = StopToken("tablet-3", "Tablet 3", "martha", "Martha Keller", "farm")


def test_a_signed_token_reads_back() -> None:
    assert StopToken.read(MARTHA.sign(SECRET), SECRET) == MARTHA


def test_a_tablet_on_the_sign_in_page_presses_in_its_own_name() -> None:
    assert StopToken("tablet-3", "Tablet 3", "", "", "farm").who == "Tablet 3"
    assert MARTHA.who == "Martha Keller"


def test_a_token_of_another_installation_is_refused() -> None:
    with pytest.raises(BadStopToken):
        StopToken.read(MARTHA.sign("another-secret"), SECRET)


@given(st.text(max_size=300))
def test_no_text_passes_that_was_not_signed_here(text: str) -> None:
    with pytest.raises(BadStopToken):
        StopToken.read(text, SECRET)


@given(st.integers(0, 500), st.characters())
def test_one_changed_character_is_refused(place: int, character: str) -> None:
    token = MARTHA.sign(SECRET)
    place %= len(token)
    if token[place] != character:
        changed = token[:place] + character + token[place + 1 :]
        with suppress(BadStopToken):  # base64 has spare bits: another text may decode to the same token
            assert StopToken.read(changed, SECRET) == MARTHA
