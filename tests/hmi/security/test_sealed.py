"""What is sealed opens with the same secret and purpose only."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hmi.security.sealed import Seal

SEAL = Seal("0123456789abcdef", "camera sources")


@given(st.text(st.characters(codec="utf-8"), max_size=60))
def test_a_sealed_text_opens_again(text: str) -> None:
    assert SEAL.open(SEAL.seal(text)) == text


def test_a_sealed_text_shows_nothing_of_what_is_in_it() -> None:
    assert "hunter2" not in SEAL.seal("hunter2")
    assert SEAL.seal("hunter2") != SEAL.seal("hunter2")
    assert SEAL.seal("") == ""


def test_another_secret_or_purpose_opens_nothing() -> None:
    sealed = SEAL.seal("hunter2")
    assert Seal("another secret 0", "camera sources").open(sealed) is None
    assert Seal("0123456789abcdef", "mail").open(sealed) is None
    assert SEAL.open(sealed[:-4] + "AAAA") is None
    assert SEAL.open("not sealed") is None
