"""Ids of the entities that carry missions through a context broker."""

from __future__ import annotations

from backend_clients.ngsi.identifier import EntityRef, check_ref

ORDER, ANSWER, PRESENCE = "CommandMessage", "CommandReturnMessage", "Device"
COMMAND = "mission"
OWN = "headland"  # attribute with what the models have no place for


def order_ref(farm: str, robot: str, order: str) -> EntityRef:
    """Return the entity of an order; each order is one of its own, so that none is written over."""
    return _ref(ORDER, farm, f"{robot}:{order}")


def answer_ref(farm: str, robot: str, order: str) -> EntityRef:
    """Return the entity of the answer to an order."""
    return _ref(ANSWER, farm, f"{robot}:{order}")


def presence_ref(farm: str, robot: str) -> EntityRef:
    """Return the entity by which a robot's cloud agent says that it is there."""
    return _ref(PRESENCE, farm, f"{robot}:cloud-agent")


def prefix(kind: str, farm: str) -> str:
    """Return what the ids of one farm's entities of a kind begin with."""
    return f"urn:ngsi-ld:{kind}:{farm}:"


def _ref(kind: str, farm: str, name: str) -> EntityRef:
    return check_ref(EntityRef(f"{prefix(kind, farm)}{name}", kind))
