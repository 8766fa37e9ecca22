"""Where a camera may be, and where never."""

from __future__ import annotations

import ipaddress
from urllib.parse import urlsplit

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.camera import SourceKind
from hmi.domain.camera_source import (
    Place,
    Reach,
    Source,
    SourceRefused,
    check_url,
    pin,
    pinned_url,
    reach_of,
)

FARM = reach_of(["192.168.7.0/24", "2001:db8:7::/64"], "http://10.0.0.5:9000", is_demo=False)
DEMO = reach_of([], "http://127.0.0.1:9000", is_demo=True)
OPEN = reach_of(["0.0.0.0/0", "::/0"], None, is_demo=False)
ADDRESSES = st.ip_addresses()


def code(kind: SourceKind, url: str, reach: Reach = FARM) -> str:
    """Return why a URL is refused, empty if it is not."""
    try:
        check_url(kind, url, reach)
    except SourceRefused as error:
        return error.code if error.text.endswith(".") else f"no sentence: {error.text}"
    return ""


@pytest.mark.parametrize(
    ("kind", "url"),
    [
        (SourceKind.RTSP, "rtsp://192.168.7.20/stream1?a=b"),
        (SourceKind.RTSP, "rtsps://[2001:db8:7::20]:322/x"),
        (SourceKind.MJPEG, "http://camera-3.farm.lan:8080/video.mjpg"),
        (SourceKind.WHEP, "https://192.168.7.9/whep/barn"),
        (SourceKind.SNAPSHOT, "HTTP://10.0.0.5/still.jpg"),
    ],
)
def test_cameras_in_the_camera_network_and_on_the_robot_are_allowed(kind: SourceKind, url: str) -> None:
    assert code(kind, url) == ""


@pytest.mark.parametrize(
    ("kind", "url", "why"),
    [
        (SourceKind.MJPEG, "file:///etc/passwd", "scheme"),
        (SourceKind.RTSP, "http://192.168.7.20/", "scheme"),
        (SourceKind.MJPEG, "rtsp://192.168.7.20/", "scheme"),
        (SourceKind.RTSP, "concat:rtsp://192.168.7.20/|/etc/passwd", "scheme"),
        (SourceKind.UPLOAD, "http://192.168.7.20/", "scheme"),
        (SourceKind.MJPEG, "http://admin:pw@192.168.7.20/", "user_info"),
        (SourceKind.MJPEG, "http://192.168.7.20@evil.example/", "user_info"),
        (SourceKind.MJPEG, "http://@192.168.7.20/", "user_info"),
        (SourceKind.MJPEG, "http://192.168.7.20/video?user=joe&loginPwd=x", "user_info"),
        (SourceKind.MJPEG, "http://169.254.169.254/latest/meta-data", "never"),
        (SourceKind.MJPEG, "http://[fe80::1]/", "never"),
        (SourceKind.MJPEG, "http://[::ffff:169.254.169.254]/", "never"),
        (SourceKind.MJPEG, "http://0.0.0.0/", "never"),
        (SourceKind.MJPEG, "http://127.0.0.1:8080/", "loopback"),
        (SourceKind.MJPEG, "http://localhost:8080/", "loopback"),
        (SourceKind.MJPEG, "http://cam.localhost./", "loopback"),
        (SourceKind.MJPEG, "http://[::1]/", "loopback"),
        (SourceKind.MJPEG, "http://[::ffff:127.0.0.1]/", "loopback"),
        (SourceKind.MJPEG, "http://[::7f00:1]/", "loopback"),
        (SourceKind.MJPEG, "http://[64:ff9b::7f00:1]/", "loopback"),
        (SourceKind.MJPEG, "http://192.168.8.20/", "network"),
        (SourceKind.MJPEG, "http://10.0.0.6/", "network"),
        (SourceKind.MJPEG, "http://2130706433/", "host"),
        (SourceKind.MJPEG, "http://0x7f.1/", "host"),
        (SourceKind.MJPEG, "http://127.1/", "host"),
        (SourceKind.MJPEG, "http://192.168.007.020/", "host"),
        (SourceKind.MJPEG, "http:///x", "host"),
        (SourceKind.MJPEG, "http://-x/", "host"),
        (SourceKind.MJPEG, "http://[fe80::1%25eth0]/", "host"),
        (SourceKind.MJPEG, "http://192.168.7.20:99999/", "bad_url"),
        (SourceKind.MJPEG, "http://192.168.7.20:0/", "bad_url"),
        (SourceKind.MJPEG, "http://192.168.7.20/#x", "bad_url"),
        (SourceKind.MJPEG, "http://192.168.7.20/a b", "bad_url"),
        (SourceKind.MJPEG, "http://192.168.7.20/\r\nX: y", "bad_url"),
        (SourceKind.MJPEG, "http://192.168.7.20\\@evil.example/", "bad_url"),
        (SourceKind.MJPEG, "http://[::1/", "bad_url"),
        (SourceKind.MJPEG, "http://k\u00e4mera/", "bad_url"),
        (SourceKind.MJPEG, "", "bad_url"),
        (SourceKind.MJPEG, "http://192.168.7.20/" + "a" * 300, "bad_url"),
    ],
)
def test_other_addresses_are_refused_with_their_reason(kind: SourceKind, url: str, why: str) -> None:
    assert code(kind, url) == why


def test_this_machine_is_allowed_in_the_demo_or_by_a_network_that_names_it() -> None:
    assert code(SourceKind.MJPEG, "http://127.0.0.1:9000/", DEMO) == ""
    assert code(SourceKind.MJPEG, "http://127.0.0.1:9000/", OPEN) == "loopback"
    named = reach_of(["127.0.0.0/8"], None, is_demo=False)
    assert code(SourceKind.MJPEG, "http://127.0.0.1:9000/", named) == ""
    assert code(SourceKind.MJPEG, "http://169.254.169.254/", DEMO) == "never"


@given(st.lists(ADDRESSES | st.ip_addresses(network="192.168.7.0/24"), min_size=1, max_size=4))
def test_a_name_is_pinned_to_the_first_address_that_may_be_a_camera(addresses: list[ipaddress.IPv4Address]) -> None:
    place = check_url(SourceKind.MJPEG, "http://cam.farm.lan/x", FARM)
    good = [str(one) for one in addresses if FARM.holds(one)]
    if good:
        assert pin(place, [str(one) for one in addresses], FARM) == good[0]
        return
    with pytest.raises(SourceRefused):
        pin(place, [str(one) for one in addresses], FARM)


@given(ADDRESSES)
def test_link_local_this_machine_and_metadata_are_never_pinned_by_a_wide_network(
    address: ipaddress.IPv4Address | ipaddress.IPv6Address,
) -> None:
    place = Place("http", "cam.example", 80, "/")
    is_bad = address.is_link_local or address.is_loopback or address.is_multicast or address.is_unspecified
    try:
        pin(place, [str(address)], OPEN)
    except SourceRefused:
        return
    assert not is_bad


@given(st.ip_addresses(network="127.0.0.0/8") | st.ip_addresses(network="169.254.0.0/16"))
def test_an_ipv6_address_that_carries_an_ipv4_one_is_judged_by_it(address: ipaddress.IPv4Address) -> None:
    place = Place("http", "cam.example", 80, "/")
    for carried in (
        f"::ffff:{address}",
        f"64:ff9b::{address}",
        str(ipaddress.IPv6Address((0x2002 << 112) | (int(address) << 80))),
    ):
        with pytest.raises(SourceRefused):
            pin(place, [carried], OPEN)


@pytest.mark.parametrize("addresses", [[], ["no address"], ["192.168.7.x"]])
def test_a_name_without_addresses_is_refused(addresses: list[str]) -> None:
    with pytest.raises(SourceRefused) as refused:
        pin(Place("http", "cam", 80, "/"), addresses, FARM)
    assert refused.value.code == "no_address"


def test_the_robots_own_host_is_allowed_by_name_and_judged_all_the_same() -> None:
    reach = reach_of([], "http://Weeder-01.farm.lan.:9000/api", is_demo=False)
    place = check_url(SourceKind.ROBOT, "http://weeder-01.farm.lan:9000/cameras", reach)
    assert pin(place, ["10.1.2.3"], reach) == "10.1.2.3"
    for bad in ("169.254.169.254", "127.0.0.1", "::1"):
        with pytest.raises(SourceRefused):
            pin(place, [bad], reach)


@given(st.text(max_size=80))
def test_any_text_is_judged_or_refused_with_a_sentence(text: str) -> None:
    for url in (text, f"http://{text}", f"http://{text}@192.168.7.20/", f"http://192.168.7.20{text}"):
        try:
            place = check_url(SourceKind.MJPEG, url, FARM)
        except SourceRefused:
            continue
        else:
            assert "@" not in urlsplit(url).netloc
            again = urlsplit(pinned_url(place, "192.168.7.20"))
            assert (again.hostname, again.port, again.username) == ("192.168.7.20", place.port, None)


@given(user=st.text(max_size=20), password=st.text(min_size=1, max_size=20))
def test_credentials_cannot_change_where_a_pinned_url_leads(user: str, password: str) -> None:
    place = check_url(SourceKind.RTSP, "rtsp://cam.farm.lan/live?x=1", FARM)
    try:
        url = pinned_url(place, "2001:db8:7::20", user, password)
    except UnicodeEncodeError:  # lone surrogates never come by JSON that is UTF-8
        return
    parts = urlsplit(url)
    assert (parts.hostname, parts.port, parts.path, parts.query) == ("2001:db8:7::20", 554, "/live", "x=1")


def test_a_source_does_not_show_its_password_in_a_log() -> None:
    assert "hunter2" not in repr(Source("weeder-01", "front", SourceKind.RTSP, "rtsp://x/", "joe", "hunter2"))
