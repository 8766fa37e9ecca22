"""`headland cert` makes certificates that a TLS client accepts."""

from __future__ import annotations

import socket
import ssl
import threading
from pathlib import Path

import pytest

from hmi.keeper.certificates import made_certificates, make_certificates
from hmi.keeper.errors import StartError


def test_a_client_that_trusts_the_authority_accepts_the_server(tmp_path: Path) -> None:
    made = make_certificates(["localhost", "127.0.0.1"], tmp_path, days=30)
    server = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    server.load_cert_chain(made.cert, made.key)
    client = ssl.create_default_context(cafile=str(made.ca))
    left, right = socket.socketpair()
    left.settimeout(5)
    right.settimeout(5)
    shake = threading.Thread(target=lambda: server.wrap_socket(left, server_side=True).close())
    shake.start()
    with client.wrap_socket(right, server_hostname="127.0.0.1") as secure:
        subject = secure.getpeercert()
    shake.join(5)
    assert subject is not None
    assert ("IP Address", "127.0.0.1") in subject["subjectAltName"]


def test_the_authority_is_kept_when_the_server_certificate_is_made_again(tmp_path: Path) -> None:
    first = make_certificates(["farm.example"], tmp_path, days=30)
    before = first.ca.read_bytes()
    second = make_certificates(["192.0.2.7"], tmp_path, days=30)
    assert second.ca.read_bytes() == before


def test_keys_are_for_their_owner_only(tmp_path: Path) -> None:
    made = make_certificates(["farm.example"], tmp_path, days=30)
    assert made.key.stat().st_mode & 0o077 == 0
    assert (tmp_path / "ca-key.pem").stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("names", [[], ["ünïcode näme"]])
def test_a_bad_name_is_refused_in_words(tmp_path: Path, names: list[str]) -> None:
    with pytest.raises(StartError):
        make_certificates(names, tmp_path, days=30)


def test_what_was_made_is_found_again(tmp_path: Path) -> None:
    made = make_certificates(["farm.example"], tmp_path, days=30)
    assert made_certificates(tmp_path) == made


@pytest.mark.parametrize("lost", ["server.pem", "server-key.pem"])
def test_a_lost_certificate_or_key_says_how_to_make_it(tmp_path: Path, lost: str) -> None:
    make_certificates(["farm.example"], tmp_path, days=30)
    (tmp_path / lost).unlink()
    with pytest.raises(StartError, match="headland cert ADDRESS"):
        made_certificates(tmp_path)


def test_a_certificate_that_ran_out_says_when(tmp_path: Path) -> None:
    make_certificates(["farm.example"], tmp_path, days=0)
    with pytest.raises(StartError, match="ran out on"):
        made_certificates(tmp_path)
