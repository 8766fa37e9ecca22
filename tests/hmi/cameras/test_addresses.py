"""Which addresses cameras may have, judged after the name is resolved."""

from __future__ import annotations

import pytest

from hmi.cameras.addresses import BadAddress, target_of
from hmi.domain.camera import SourceKind


@pytest.mark.parametrize(
    ("url", "nets", "why"),
    [
        ("file:///etc/passwd", (), "must begin with http:// or https://"),
        ("rtsp://127.0.0.1/", (), "must begin with http:// or https://"),
        ("http:///path", (), "must begin with"),
        ("http://169.254.169.254/latest", (), "not an address cameras may have"),
        ("http://[::ffff:169.254.169.254]/", (), "not an address cameras may have"),
        ("http://[fe80::1]/", (), "not an address cameras may have"),
        ("http://224.0.0.1/", (), "not an address cameras may have"),
        ("http://0.0.0.0:80/", (), "not an address cameras may have"),
        ("http://127.0.0.1/", ("10.0.0.0/8",), "not an address cameras may have"),
        ("http://0x7f000001/", ("10.0.0.0/8",), "not an address cameras may have"),
        ("http://127.0.0.1:x/", (), "not an address"),
    ],
)
def test_an_address_that_may_not_be_opened_is_refused_in_words(url: str, nets: tuple[str, ...], why: str) -> None:
    with pytest.raises(BadAddress, match=why):
        target_of(url, SourceKind.MJPEG, nets)


def test_the_address_itself_is_used_and_the_name_goes_along() -> None:
    target = target_of("http://me:secret@localhost:8123/a?b=1", SourceKind.MJPEG, ("127.0.0.0/8",))
    assert (target.url, target.host, target.hostname) == ("http://127.0.0.1:8123/a?b=1", "localhost:8123", "localhost")
