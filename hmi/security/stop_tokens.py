"""Issues STOP tokens at sign-in and enrolment, and reads them on the console's second STOP path.

The STOP gateway reads them by itself (``hmi.domain.stop_token``), with console and database dead.
"""

from __future__ import annotations

from collections.abc import Callable

from hmi.domain.stop_token import BadStopToken, StopToken
from hmi.security.errors import BadToken
from hmi.security.session_info import SessionInfo
from hmi.store.devices import Device

UNNAMED_DEVICE = "a browser"  # what a robot and a log read where the tablet is not enrolled


class StopTokens:
    """Makes and checks the tokens of one installation; synchronous, in memory.

    Args:
        secret: the installation's secret, shared with the STOP gateway.
        is_revoked: answers from memory whether a device was taken out, e.g. ``Devices.is_revoked``.
    """

    def __init__(self, secret: str, is_revoked: Callable[[str], bool]) -> None:
        self._secret = secret
        self._is_revoked = is_revoked

    def issue_stop_token(self, session: SessionInfo) -> str:
        """Return the token for a signed-in browser."""
        token = StopToken(
            device_id=session.device_id,
            device_name=session.device_name or UNNAMED_DEVICE,
            user_id=session.user_id,
            user_name=session.user_name,
            farm_id=session.farm_id,
        )
        return token.sign(self._secret)

    def issue_for_device(self, device: Device) -> str:
        """Return the token of an enrolled tablet on which nobody is signed in: STOP works on its sign-in page."""
        return StopToken(device.id, device.name, "", "", device.farm_id).sign(self._secret)

    def read_stop_token(self, text: str) -> StopToken:
        """Return what a token says.

        Raises:
            BadToken: forged, damaged, or of a device that was taken out.
        """
        try:
            token = StopToken.read(text, self._secret)
        except BadStopToken as error:
            raise BadToken("This STOP token is not valid here. Sign in again.") from error
        if self._is_revoked(token.device_id):
            raise BadToken("This tablet was taken out. Use the button on the machine.", "revoked")
        return token
