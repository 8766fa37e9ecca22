"""The two ways out: an HTTP POST and a mail. Each tries once and says what went wrong, without secrets."""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import smtplib
import socket
import ssl
from email.message import EmailMessage
from email.utils import formatdate, make_msgid
from functools import cache
from urllib.parse import urlsplit, urlunsplit

import httpx

from hmi.notifications.address import AddressRules, Target
from hmi.notifications.channel import Channel, Mail, Security, Webhook
from hmi.notifications.errors import NotDelivered
from hmi.notifications.message import Message

LIMIT_S = 10.0
SIGNATURE = "X-Headland-Signature"
EXPIRED, OTHER_NAME = 10, 62  # of OpenSSL: X509_V_ERR_CERT_HAS_EXPIRED, X509_V_ERR_HOSTNAME_MISMATCH
TRY_LATER = frozenset({408, 425, 429})


async def deliver(channel: Channel, message: Message, rules: AddressRules) -> None:
    """Send a message once.

    Raises:
        BadAddress: where it goes is not allowed.
        NotDelivered: the other side did not take it.
    """
    if isinstance(channel.way, Webhook):
        await _post(channel.way.url, channel.secret, message.payload(), rules)
    else:
        await asyncio.to_thread(_mail, channel.way, channel.secret, message, rules)


@cache
def _authorities() -> ssl.SSLContext:
    """Load the machine's certificate authorities once: each loading takes 20 to 80 ms of the loop."""
    return ssl.create_default_context()


async def _post(url: str, secret: str, body: bytes, rules: AddressRules) -> None:
    host, port = rules.check_url(url)
    target = await asyncio.to_thread(rules.find, host, port)
    headers = {"Content-Type": "application/json", "Host": urlsplit(url).netloc, "User-Agent": "Headland"}
    if secret:
        headers[SIGNATURE] = "sha256=" + hmac.new(secret.encode(), body, hashlib.sha256).hexdigest()
    try:
        async with httpx.AsyncClient(
            timeout=LIMIT_S, follow_redirects=False, trust_env=False, verify=_authorities()
        ) as client:
            request = client.build_request("POST", _at(url, target), content=body, headers=headers)
            request.extensions["sni_hostname"] = target.host
            answer = await client.send(request, stream=True)  # what it answers is not read
            await answer.aclose()
    except httpx.TimeoutException as error:
        raise NotDelivered(f"{host} did not answer within {LIMIT_S:.0f} s.") from error
    except httpx.HTTPError as error:
        if distrust := _distrust(error):
            raise NotDelivered(_not_trusted(host, distrust), is_lasting=True) from error
        raise NotDelivered(f"{host} cannot be reached: {type(error).__name__}.") from error
    _judge(host, answer.status_code)


def _judge(host: str, status: int) -> None:
    if 200 <= status < 300:
        return
    if 300 <= status < 400:
        raise NotDelivered(f"{host} sends it elsewhere ({status}); that is not followed.", is_lasting=True)
    is_lasting = status < 500 and status not in TRY_LATER
    raise NotDelivered(f"{host} answered {status}.", is_lasting=is_lasting)


def _at(url: str, target: Target) -> str:
    """Return the URL with the address that was judged in place of the name."""
    parts = urlsplit(url)
    host = f"[{target.address}]" if ":" in target.address else target.address
    return urlunsplit((parts.scheme, f"{host}:{target.port}", parts.path or "/", parts.query, ""))


def _mail(mail: Mail, password: str, message: Message, rules: AddressRules) -> None:
    target = rules.find(mail.host, mail.port)
    try:
        with _connected(mail, target) as server:
            if mail.security is Security.STARTTLS:
                server._host = mail.host  # type: ignore[attr-defined]
                server.starttls(context=ssl.create_default_context())
            if mail.user:
                server.login(mail.user, password)
            letter = _letter(mail, message)
            refused = server.send_message(letter, from_addr=mail.sender, to_addrs=list(mail.recipients))
    except smtplib.SMTPAuthenticationError as error:
        raise NotDelivered(f"{mail.host} refused name or password.", is_lasting=True) from error
    except smtplib.SMTPRecipientsRefused as error:
        raise NotDelivered(f"{mail.host} refused the recipients.", is_lasting=True) from error
    except smtplib.SMTPResponseException as error:
        text = f"{mail.host} answered {error.smtp_code}."
        raise NotDelivered(text, is_lasting=error.smtp_code >= 500) from error
    except ssl.SSLCertVerificationError as error:
        raise NotDelivered(_not_trusted(mail.host, error), is_lasting=True) from error
    except ssl.SSLError as error:
        text = f"{mail.host} does not speak TLS as expected. Check the port, and tls or starttls."
        raise NotDelivered(text, is_lasting=True) from error
    except (OSError, smtplib.SMTPException) as error:
        raise NotDelivered(f"{mail.host} cannot be reached: {type(error).__name__}.") from error
    if refused:  # the others have it; to try again would tell them twice
        raise NotDelivered(f"{mail.host} refused {', '.join(sorted(refused))}.", is_lasting=True)


def _distrust(error: BaseException | None) -> ssl.SSLCertVerificationError | None:
    """Return why a certificate was not trusted, however deep in what a client raised."""
    while error is not None:
        if isinstance(error, ssl.SSLCertVerificationError):
            return error
        error = error.__cause__ or error.__context__
    return None


def _not_trusted(host: str, error: ssl.SSLCertVerificationError) -> str:
    """Say what is wrong with a certificate, and what mends it."""
    if error.verify_code == EXPIRED:
        return f"The certificate of {host} has expired. Renew it there."
    if error.verify_code == OTHER_NAME:
        return f"The certificate of {host} is for another name. Use the name that stands in it."
    return f"The certificate of {host} cannot be trusted. An own authority goes into SSL_CERT_FILE of the console."


def _connected(mail: Mail, target: Target) -> smtplib.SMTP:
    if mail.security is Security.TLS:
        return _JudgedTls(mail.host, target)
    return smtplib.SMTP(target.address, target.port, timeout=LIMIT_S)


class _JudgedTls(smtplib.SMTP_SSL):
    """Connects to the address that was judged and checks the certificate for the name."""

    def __init__(self, host: str, target: Target) -> None:
        self._target = target
        super().__init__(host, target.port, timeout=LIMIT_S, context=ssl.create_default_context())

    def _get_socket(self, host: str, port: int, timeout: float) -> ssl.SSLSocket:
        raw = socket.create_connection((self._target.address, self._target.port), timeout)
        context: ssl.SSLContext = self.context
        return context.wrap_socket(raw, server_hostname=host)


def _letter(mail: Mail, message: Message) -> EmailMessage:
    letter = EmailMessage()
    letter["Subject"] = message.subject
    letter["From"] = mail.sender
    letter["To"] = ", ".join(mail.recipients)
    letter["Date"] = formatdate(localtime=False)
    letter["Message-ID"] = make_msgid(domain=mail.sender.rpartition("@")[2])
    letter["Auto-Submitted"] = "auto-generated"
    if message.priority == 1:
        letter["X-Priority"] = "1"
    letter.set_content(message.body())
    return letter
