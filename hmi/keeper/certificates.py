"""A local certificate authority and a server certificate, made with ``cryptography``."""

from __future__ import annotations

import ipaddress
import os
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from hmi.keeper.errors import StartError

CA_DAYS = 3650
BACKDATE = timedelta(days=1)  # tablets' clocks run behind


@dataclass(frozen=True, slots=True)
class Certificates:
    """Paths of what was made."""

    ca: Path
    cert: Path
    key: Path


def make_certificates(names: Sequence[str], folder: Path, *, days: int) -> Certificates:
    """Make ``ca.pem`` (kept if it exists) and ``server.pem``/``server-key.pem`` valid for ``names``.

    Raises:
        StartError: no name given, a bad name, or the folder cannot be written.
    """
    alternatives = [_alternative(name) for name in names]
    if not alternatives:
        raise StartError("Give at least one host name or address, as tablets will type it.")
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        ca_key, ca = _authority(folder)
        key = ec.generate_private_key(ec.SECP256R1())
        cert = _server(names[0], alternatives, key.public_key(), ca, ca_key, days)
        _write(folder / "server.pem", cert.public_bytes(serialization.Encoding.PEM))
        _write_key(folder / "server-key.pem", key)
    except OSError as error:
        raise StartError(f"Cannot write certificates to {folder} ({error.strerror}).") from error
    return _in(folder)


def made_certificates(folder: Path) -> Certificates:
    """Return what ``make_certificates`` left in ``folder``.

    Raises:
        StartError: nothing is there, or it has run out.
    """
    made = _in(folder)
    again = "Make one with `headland cert ADDRESS`, where ADDRESS is what tablets type."
    try:
        until = x509.load_pem_x509_certificate(made.cert.read_bytes()).not_valid_after_utc
    except (OSError, ValueError) as error:
        raise StartError(f"There is no certificate in {folder}. {again}") from error
    if not made.key.is_file():
        raise StartError(f"The key of {made.cert} is missing. {again}")
    if until < datetime.now(UTC):
        raise StartError(f"The certificate in {folder} ran out on {until:%d %B %Y}. {again}")
    return made


def _in(folder: Path) -> Certificates:
    return Certificates(folder / "ca.pem", folder / "server.pem", folder / "server-key.pem")


def _alternative(name: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        pass
    try:
        return x509.DNSName(name)
    except ValueError as error:
        raise StartError(f"{name!r} is neither a host name nor an address.") from error


def _authority(folder: Path) -> tuple[ec.EllipticCurvePrivateKey, x509.Certificate]:
    cert_path, key_path = folder / "ca.pem", folder / "ca-key.pem"
    if cert_path.exists() and key_path.exists():
        key = serialization.load_pem_private_key(key_path.read_bytes(), password=None)
        if not isinstance(key, ec.EllipticCurvePrivateKey):
            raise StartError(f"{key_path} is not a key made by `headland cert`.")
        return key, x509.load_pem_x509_certificate(cert_path.read_bytes())
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "Headland local authority")])
    now = datetime.now(UTC)
    cert = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - BACKDATE)
        .not_valid_after(now + timedelta(days=CA_DAYS))
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(_usage(signs_certificates=True), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .sign(key, hashes.SHA256())
    )
    _write_key(key_path, key)
    _write(cert_path, cert.public_bytes(serialization.Encoding.PEM))
    return key, cert


def _server(
    name: str,
    alternatives: Sequence[x509.GeneralName],
    key: ec.EllipticCurvePublicKey,
    ca: x509.Certificate,
    ca_key: ec.EllipticCurvePrivateKey,
    days: int,
) -> x509.Certificate:
    now = datetime.now(UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name[:64])]))
        .issuer_name(ca.subject)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - BACKDATE)
        .not_valid_after(now + timedelta(days=days))
        .add_extension(x509.SubjectAlternativeName(alternatives), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(_usage(signs_certificates=False), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(ca_key.public_key()), critical=False)
        .sign(ca_key, hashes.SHA256())
    )


def _usage(*, signs_certificates: bool) -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=not signs_certificates,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=signs_certificates,
        crl_sign=signs_certificates,
        encipher_only=False,
        decipher_only=False,
    )


def _write(path: Path, content: bytes) -> None:
    path.write_bytes(content)


def _write_key(path: Path, key: ec.EllipticCurvePrivateKey) -> None:
    content = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    path.unlink(missing_ok=True)
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "wb") as file:
        file.write(content)
