"""Turns as quaternions w, x, y, z; plain floats, since arrays of four cost more than they save."""

from __future__ import annotations

import math

from hmi.twin.model import Quaternion, Vector

IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the turn that does ``b`` first, then ``a``."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def about(axis: Vector, angle_rad: float) -> Quaternion:
    """Return a turn about a unit axis."""
    half = 0.5 * angle_rad
    s = math.sin(half)
    return math.cos(half), axis[0] * s, axis[1] * s, axis[2] * s


def yaw(angle_rad: float) -> Quaternion:
    """Return a turn about z."""
    half = 0.5 * angle_rad
    return math.cos(half), 0.0, 0.0, math.sin(half)


def from_rpy(rpy: Vector) -> Quaternion:
    """Return roll about x, then pitch about y, then yaw about z, all of the fixed frame, as URDF has it."""
    roll, pitch, turn = rpy
    about_z, about_y = yaw(turn), about((0.0, 1.0, 0.0), pitch)
    return product(product(about_z, about_y), about((1.0, 0.0, 0.0), roll))


def turned(q: Quaternion, v: Vector) -> Vector:
    """Return a vector turned by a unit quaternion."""
    w, x, y, z = q
    vx, vy, vz = v
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx


def is_near(a: Quaternion, b: Quaternion, angle_rad: float) -> bool:
    """Say whether two turns differ by less than an angle."""
    dot = abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3])
    # cos(angle / 2) near one: 1 - dot is angle^2 / 8
    return 1.0 - dot < angle_rad * angle_rad / 8
