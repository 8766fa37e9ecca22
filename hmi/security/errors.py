"""The errors of signing in and of rights; each carries a code for machines and a sentence for a person.

::

    SecurityError
    ├── NotSignedIn            no session, or it ended
    ├── NotAllowed             the role, the robot or the farm forbids it
    ├── SignInRefused          signing in failed
    │   ├── WrongCredentials   unknown name, wrong password or wrong PIN
    │   ├── TooManyTries       wait ``retry_after_s`` first
    │   └── NotEnrolled        a PIN works on enrolled devices only
    ├── BadAccount             what an administrator asked for is not possible
    │   └── WeakPassword       the password or PIN breaks a rule
    └── BadToken               a STOP token is forged, damaged or revoked
"""

from __future__ import annotations


class SecurityError(Exception):
    """Root of all errors of this package.

    Args:
        text: one sentence for a person, ready to be shown.
        code: stable machine-readable reason.
    """

    code = "refused"
    http_status = 403

    def __init__(self, text: str, code: str | None = None) -> None:
        super().__init__(text)
        self.text = text
        if code is not None:
            self.code = code


class NotSignedIn(SecurityError):
    """There is no session, or it ended."""

    code = "not_signed_in"
    http_status = 401

    def __init__(self, text: str = "You are not signed in. Sign in first.") -> None:
        super().__init__(text)


class NotAllowed(SecurityError):
    """This person may not do this, or not with this robot."""

    code = "not_allowed"
    http_status = 403


class SignInRefused(SecurityError):
    """Signing in failed."""

    code = "sign_in_refused"
    http_status = 401


class WrongCredentials(SignInRefused):
    """Unknown name, wrong password or wrong PIN; which of them is never said."""

    code = "wrong_credentials"


class TooManyTries(SignInRefused):
    """Too many wrong tries: nothing was checked, the next try counts after ``retry_after_s``."""

    code = "too_many_tries"
    http_status = 429

    def __init__(self, text: str, retry_after_s: float) -> None:
        super().__init__(text)
        self.retry_after_s = retry_after_s


class NotEnrolled(SignInRefused):
    """A PIN was entered on a device that is not enrolled."""

    code = "not_enrolled"


class BadAccount(SecurityError):
    """What was asked for an account is not possible; ``field`` names the input at fault."""

    code = "bad_account"
    http_status = 422

    def __init__(self, text: str, field: str, code: str | None = None) -> None:
        super().__init__(text, code)
        self.field = field


class WeakPassword(BadAccount):
    """The password or PIN breaks a rule; the text says which."""

    code = "weak_password"


class BadToken(SecurityError):
    """A STOP token is forged, damaged or revoked."""

    code = "bad_token"
    http_status = 401
