"""Mail over TLS, against a server with the certificate of an own authority."""

from __future__ import annotations

import asyncio
import base64
import ssl
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from hmi.notifications.address import AddressRules
from hmi.notifications.channel import Channel, Mail, Security
from hmi.notifications.errors import NotDelivered
from hmi.notifications.message import Message
from hmi.notifications.ways import deliver

HOST, USER, PASSWORD = "mail.farm.example", "headland", "seven words"
RULES = AddressRules(is_private_allowed=True, resolve=lambda _host, _port: ["127.0.0.1"])


class Authority:
    """An own certificate authority of a farm."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._key = ec.generate_private_key(ec.SECP256R1())
        self._name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "Farm")])
        self._put("authority.pem", self._signed("authority", self._name, self._key, is_authority=True))

    def _signed(
        self, host: str, subject: x509.Name, key: ec.EllipticCurvePrivateKey, *, is_authority: bool, days: int = 9
    ) -> bytes:
        now = datetime.now(UTC)
        builder = (
            x509.CertificateBuilder(self._name, subject, key.public_key(), x509.random_serial_number())
            .not_valid_before(now - timedelta(days=20))
            .not_valid_after(now + timedelta(days=days))
            .add_extension(x509.BasicConstraints(ca=is_authority, path_length=None), critical=True)
            .add_extension(x509.SubjectAlternativeName([x509.DNSName(host)]), critical=False)
        )
        return builder.sign(self._key, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)

    def _put(self, name: str, data: bytes) -> Path:
        path = self.folder / name
        path.write_bytes(data)
        return path

    def server(self, host: str = HOST, days: int = 9) -> ssl.SSLContext:
        """Return what a server presents itself with."""
        key = ec.generate_private_key(ec.SECP256R1())
        pem = key.private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        )
        subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, host)])
        certificate = self._put("server.pem", self._signed(host, subject, key, is_authority=False, days=days))
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(certificate, self._put("server.key", pem))
        return context


class MailServer:
    """Takes one mail over TLS from who knows the password; nothing in the clear."""

    def __init__(self, context: ssl.SSLContext, *, is_tls_first: bool) -> None:
        self._context, self._is_tls_first = context, is_tls_first
        self.mail = ""

    @asynccontextmanager
    async def listening(self) -> AsyncIterator[int]:
        """Serve on a free port."""
        context = self._context if self._is_tls_first else None
        server = await asyncio.start_server(self._serve, "127.0.0.1", 0, ssl=context)
        async with server:
            yield server.sockets[0].getsockname()[1]

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        is_secret = self._is_tls_first
        writer.write(b"220 mail\r\n")
        try:
            while line := (await reader.readline()).decode().strip():
                match line.split(" ")[0].upper():
                    case "EHLO":
                        writer.write(
                            b"250-mail\r\n250 AUTH PLAIN\r\n" if is_secret else b"250-mail\r\n250 STARTTLS\r\n"
                        )
                    case "STARTTLS":
                        writer.write(b"220 go on\r\n")
                        await writer.start_tls(self._context)
                        is_secret = True
                    case "AUTH":
                        given = base64.b64decode(line.split(" ")[2]).decode().split("\0")[1:]
                        is_right = is_secret and given == [USER, PASSWORD]
                        writer.write(b"235 welcome\r\n" if is_right else b"535 wrong\r\n")
                    case "DATA":
                        writer.write(b"354 go on\r\n")
                        self.mail = (await reader.readuntil(b"\r\n.\r\n")).decode()
                        writer.write(b"250 taken\r\n")
                    case "QUIT":
                        writer.write(b"221 bye\r\n")
                    case _:
                        writer.write(b"250 well\r\n")
        except (OSError, asyncio.IncompleteReadError):
            pass  # the other side went: its test looks at why
        finally:
            writer.close()


@pytest.fixture
def authority(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Authority:
    """An authority that this machine trusts."""
    made = Authority(tmp_path)
    monkeypatch.setenv("SSL_CERT_FILE", str(tmp_path / "authority.pem"))
    return made


async def send(server: MailServer, security: Security, password: str = PASSWORD) -> None:
    """Send a test by a channel to this server."""
    async with server.listening() as port:
        mail = Mail(HOST, port, security, USER, "headland@farm.example", ("anna@farm.example",))
        channel = Channel("mail", "Mail", True, mail, frozenset(), frozenset(), secret=password)
        await deliver(channel, Message("Hof Brandt", (), is_test=True), RULES)


WAYS = pytest.mark.parametrize("security", [Security.STARTTLS, Security.TLS])


def server_of(context: ssl.SSLContext, security: Security) -> MailServer:
    """Return a server that speaks TLS at once, or when asked."""
    return MailServer(context, is_tls_first=security is Security.TLS)


@WAYS
async def test_a_mail_travels_encrypted_to_a_server_of_an_own_authority(
    authority: Authority, security: Security
) -> None:
    server = server_of(authority.server(), security)
    await send(server, security)
    assert "Subject: Hof Brandt: test of the alarm notification" in server.mail


@WAYS
@pytest.mark.parametrize(
    ("host", "days", "words"),
    [(HOST, -3, "has expired. Renew it there."), ("other.example", 9, "is for another name.")],
)
async def test_a_certificate_that_is_wrong_is_refused_in_words(
    authority: Authority, security: Security, host: str, days: int, words: str
) -> None:
    server = server_of(authority.server(host, days), security)
    with pytest.raises(NotDelivered) as refused:
        await send(server, security)
    assert words in refused.value.text
    assert refused.value.is_lasting
    assert not server.mail


@WAYS
async def test_an_unknown_authority_is_refused_with_the_way_to_make_it_known(
    authority: Authority, security: Security, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("SSL_CERT_FILE")
    with pytest.raises(NotDelivered) as refused:
        await send(server_of(authority.server(), security), security)
    assert "SSL_CERT_FILE" in refused.value.text


@WAYS
async def test_a_wrong_password_is_said_and_not_tried_again(authority: Authority, security: Security) -> None:
    with pytest.raises(NotDelivered) as refused:
        await send(server_of(authority.server(), security), security, password="guessed")
    assert refused.value.text == f"{HOST} refused name or password."
    assert refused.value.is_lasting


async def test_tls_at_a_port_that_speaks_starttls_says_what_to_check(authority: Authority) -> None:
    with pytest.raises(NotDelivered) as refused:
        await send(MailServer(authority.server(), is_tls_first=False), Security.TLS)
    assert "Check the port, and tls or starttls." in refused.value.text
