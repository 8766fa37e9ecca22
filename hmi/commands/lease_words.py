"""What a change of control is called: the sentence for people, the event for the lane."""

from __future__ import annotations

from typing import Any

from hmi.domain.lease import Lease, LeaseAnswer, LeaseCode


def owner_of(lease: Lease | None) -> dict[str, str] | None:
    """Return the visible owner as in the group ``lease`` of the live lane."""
    if lease is None:
        return None
    holder = lease.holder
    return {
        "user": holder.user_id,
        "name": holder.user_name,
        "device": holder.device_name,
        "session": holder.session_id,
    }


def asked_of(lease: Lease | None) -> list[dict[str, str]]:
    """Return who asks for control, oldest first, as in the group ``lease``."""
    if lease is None:
        return []
    return [{"user": a.holder.user_id, "name": a.holder.user_name, "session": a.holder.session_id} for a in lease.asks]


def lease_event(robot_id: str, op: str, text: str, lease: Lease | None, *, by: str) -> dict[str, Any]:
    """Return the lane event that tells everybody who has control now."""
    return {
        "kind": "lease",
        "robot": robot_id,
        "op": op,
        "by": by,
        "text": text,
        "owner": owner_of(lease),
        "asked": asked_of(lease),
    }


def lease_text(robot_name: str, answer: LeaseAnswer) -> str:
    """Return one sentence on what an operation came to."""
    owner = answer.lease.holder.user_name if answer.lease is not None else "Nobody"
    if answer.code is LeaseCode.RELEASED and answer.ended is None:
        return f"No longer asking for {robot_name}."
    return {
        LeaseCode.GRANTED: f"{owner} has control of {robot_name}.",
        LeaseCode.RELEASED: f"Nobody has control of {robot_name}.",
        LeaseCode.ASKED: f"Asked {owner} for control of {robot_name}.",
        LeaseCode.KEPT: f"{owner} keeps control of {robot_name}.",
        LeaseCode.HELD_BY_OTHER: f"{owner} has control. Ask for it.",
        LeaseCode.NOT_HOLDER: f"{owner} has control of {robot_name}, not this screen.",
        LeaseCode.NOBODY_ASKS: f"Nobody asks for {robot_name} any more.",
        LeaseCode.TOO_MANY_ASK: f"Too many people ask for {robot_name} already.",
        LeaseCode.NO_TOKENS: "Control cannot be given out right now. Try again in a few seconds.",
    }[answer.code]
