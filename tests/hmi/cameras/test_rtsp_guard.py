"""An RTSP camera leads nowhere but to the address that was judged, and by TLS it must show who it is."""

from __future__ import annotations

import asyncio
import datetime
import ipaddress
import ssl
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from hmi.cameras.addresses import target_of
from hmi.cameras.inbox import Inbox
from hmi.cameras.pull_http import PullFailed
from hmi.cameras.pull_rtsp import RtspPull
from hmi.cameras.pull_whep import place_of
from hmi.cameras.rtsp_guard import RtspGuard
from hmi.domain.camera import CameraInfo, Source, SourceKind
from tests.hmi.cameras.rtsp_server import rtsp_server

HERE = ("127.0.0.0/8",)


async def pulled(url: str) -> str:
    """Return why a source cannot be pulled."""
    source = Source("weeder-01", CameraInfo("front", "Front", 320, 240), SourceKind.RTSP, url, nets=HERE)
    with pytest.raises(PullFailed) as failed:
        await asyncio.to_thread(RtspPull(source, Inbox()).run)
    return str(failed.value)


async def said(url: str) -> bytes:
    """Return the first words of a camera that is asked through a guard."""

    def asked(place: str) -> bytes:
        async def ask() -> bytes:
            reader, writer = await asyncio.open_connection("127.0.0.1", urlsplit(place).port)
            writer.write(b"OPTIONS * RTSP/1.0\r\nCSeq: 1\r\n\r\n")
            words = await reader.read(200)
            writer.close()
            return words

        return asyncio.run(ask())

    def guarded() -> bytes:
        with RtspGuard(target_of(url, SourceKind.RTSP, HERE)) as guard:
            return asked(guard.url)

    return await asyncio.to_thread(guarded)


@pytest.fixture
def certificate(tmp_path: Path) -> Path:
    """Return a file with a certificate of 127.0.0.1 and its key."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "camera")])
    made = (
        x509.CertificateBuilder()
        .subject_name(name).issuer_name(name).public_key(key.public_key()).serial_number(1)
        .not_valid_before(datetime.datetime(2020, 1, 1, tzinfo=datetime.UTC))
        .not_valid_after(datetime.datetime(2120, 1, 1, tzinfo=datetime.UTC))
        .add_extension(x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )  # fmt: skip
    pem = key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    path = tmp_path / "camera.pem"
    path.write_bytes(pem + made.public_bytes(serialization.Encoding.PEM))
    return path


async def test_a_camera_that_sends_elsewhere_is_not_followed() -> None:
    async with rtsp_server() as other, rtsp_server() as camera:
        camera.sends_to = other.url
        assert await pulled(camera.url) == "the camera sends elsewhere, which is not followed"
        assert other.heard == 0


async def test_nobody_at_the_address_is_said_so() -> None:
    async with rtsp_server() as camera:
        url = camera.url
    assert await pulled(url) == "nothing answers at the camera's address"


async def test_a_camera_that_cannot_show_who_it_is_gets_no_word(
    certificate: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trust = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    trust.load_cert_chain(certificate)
    async with rtsp_server(trust=trust) as camera:
        assert await pulled(camera.url) == "the camera's certificate is not one that this machine trusts"
        assert camera.heard == 0
        monkeypatch.setenv("SSL_CERT_FILE", str(certificate))
        assert (await said(camera.url)).startswith(b"RTSP/1.0 200 OK")


@pytest.mark.parametrize(
    ("location", "place"),
    [
        ("/sessions/7", "http://192.168.1.5:8889/sessions/7"),
        ("http://192.168.1.5:8889/sessions/7", "http://192.168.1.5:8889/sessions/7"),
        ("http://192.168.1.5:8889@10.0.0.1:8500/x", ""),
        ("http://me@192.168.1.5:8889/x", ""),
        ("http://192.168.1.50:8889/x", ""),
        ("http://192.168.1.5:88890/x", ""),
        ("https://192.168.1.5:8889/x", ""),
        ("//10.0.0.1:8889/x", ""),
        ("http://[", ""),
        ("", ""),
    ],
)
def test_a_session_is_ended_at_the_camera_and_nowhere_else(location: str, place: str) -> None:
    assert place_of("http://192.168.1.5:8889/whep", location) == place
