"""Rights: by role, farm and registry, refused in words that say who could."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.domain.role import PERMISSIONS, Permission, Role
from hmi.security.authorization import Authorizer, is_allowed, refusal
from hmi.security.errors import NotAllowed, NotSignedIn, SecurityError
from hmi.security.session_info import SessionInfo


class Known(NamedTuple):
    """A robot as the registry knows it."""

    name: str
    farm_id: str


ROBOTS = {"weeder-07": Known("Weeder 07", "farm"), "uav-09": Known("Kestrel 9", "north")}
authorize = Authorizer(ROBOTS.get)


def session(role: Role) -> SessionInfo:
    """Return a signed-in browser."""
    return SessionInfo("s", "u", "Martha Keller", role, "d", "Tablet 3", "farm", "csrf", datetime.now(UTC))


def test_nobody_may_do_nothing_without_signing_in() -> None:
    for permission in Permission:
        with pytest.raises(NotSignedIn):
            authorize(None, permission, "weeder-07")


@given(st.sampled_from(Role), st.sampled_from(Permission))
def test_the_table_decides(role: Role, permission: Permission) -> None:
    text = is_allowed(authorize, session(role), permission, "weeder-07")
    assert (text == "") == (permission in PERMISSIONS[role])


@pytest.mark.parametrize(
    ("role", "permission", "text"),
    [
        (Role.VIEWER, Permission.DRIVE, "You can watch Weeder 07. Driving needs the operator role."),
        (Role.OPERATOR, Permission.EDIT_MAP, "You can watch Weeder 07. Changing maps needs the planner role."),
        (Role.OPERATOR, Permission.DISPATCH, "You can watch Weeder 07. Sending a robot out needs the dispatcher role."),
        (Role.SUPERVISOR, Permission.MANAGE_USERS, "You can watch Weeder 07. Changing people needs the admin role."),
    ],
)
def test_a_refusal_says_what_one_may_and_who_could(role: Role, permission: Permission, text: str) -> None:
    with pytest.raises(NotAllowed) as refused:
        authorize(session(role), permission, "weeder-07")
    assert refused.value.text == text
    assert (refused.value.code, refused.value.http_status) == ("not_allowed", 403)


def test_every_permission_can_be_refused_in_words() -> None:
    assert refusal(Role.VIEWER, Permission.READ_AUDIT, None) == "Reading the audit log needs the supervisor role."
    for permission in Permission:
        assert refusal(Role.VIEWER, permission, None).endswith("role.")


@pytest.mark.parametrize("permission", list(Permission))
def test_robots_of_other_farms_are_refused_even_to_an_admin(permission: Permission) -> None:
    with pytest.raises(NotAllowed) as refused:
        authorize(session(Role.ADMIN), permission, "uav-09")
    assert refused.value.code == "other_farm"
    assert "Kestrel" not in refused.value.text


def test_a_robot_nobody_registered_is_watched_and_never_operated() -> None:
    admin = session(Role.ADMIN)
    assert is_allowed(authorize, admin, Permission.WATCH, "new-robot") == ""
    assert is_allowed(authorize, admin, Permission.MANAGE_ROBOTS, "new-robot") == ""
    for permission in (Permission.START, Permission.DRIVE, Permission.LEASE, Permission.SEND_MISSION):
        assert is_allowed(authorize, admin, permission, "new-robot") == (
            "This robot is new here. An admin must accept it first."
        )


def test_everybody_who_signed_in_may_stop() -> None:
    for role in Role:
        authorize(session(role), Permission.STOP, "weeder-07")


def test_every_error_of_the_package_has_code_text_and_status() -> None:
    def tree(root: type[SecurityError]) -> list[type[SecurityError]]:
        return [root, *(found for child in root.__subclasses__() for found in tree(child))]

    assert {error.__name__ for error in tree(SecurityError)} == {
        "SecurityError", "NotSignedIn", "NotAllowed", "SignInRefused", "WrongCredentials", "TooManyTries",
        "NotEnrolled", "BadAccount", "WeakPassword", "BadToken",
    }  # fmt: skip
    assert all(error.http_status in (401, 403, 422, 429) and error.code for error in tree(SecurityError))
