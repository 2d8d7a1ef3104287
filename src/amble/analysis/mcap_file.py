"""Motions as MCAP, the log format that Foxglove and PlotJuggler read: messages in JSON with their schemas."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Sequence

from amble.analysis.reference import ReferenceMotion
from amble.optional import require
from amble.types import Json, Vector

XYZ, XYZW, WXYZ = ("x", "y", "z"), ("x", "y", "z", "w"), [1, 2, 3, 0]
"""Components; and places of x, y, z, w in a quaternion (w, x, y, z)."""

WORLD = "world"

NANOSECONDS = 1_000_000_000


def mcap_content(motion: ReferenceMotion) -> bytes:
    """Return a motion as an MCAP file, compressed, its times from 0.

    Topics: ``/tf`` (foxglove.FrameTransforms: every link in the frame "world", by its name), ``/joints`` (angle, rate,
    torque by joint), ``/base`` (place, turn as a quaternion, velocity in the world's axes, angular velocity in its
    own), ``/feet`` (force in the world's axes, and whether it stands, by foot), ``/gait`` (name of the stance). SI.

    Raises:
        MissingExtraError: the library is not installed.
    """
    require("mcap", "mcap", "MCAP files")
    from mcap.writer import Writer

    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start(profile="", library="amble")
    channels = {}
    for topic, (name, schema) in _schemas(motion).items():
        number = writer.register_schema(name=name, encoding="jsonschema", data=json.dumps(schema).encode())
        channels[topic] = writer.register_channel(topic=topic, message_encoding="json", schema_id=number)
    for row, time in enumerate(motion.time):
        stamp = round(float(time) * NANOSECONDS)
        for topic, message in _messages(motion, row, stamp):
            data = json.dumps(message, allow_nan=False).encode()
            writer.add_message(channel_id=channels[topic], log_time=stamp, publish_time=stamp, data=data, sequence=row)
    forward, lateral, yaw_rate = motion.command
    told = {"period_s": motion.period, "speed_m_s": forward, "lateral_speed_m_s": lateral, "yaw_rate_rad_s": yaw_rate}
    writer.add_metadata(name="amble", data={key: repr(float(value)) for key, value in told.items()})
    writer.finish()
    return stream.getvalue()


def _messages(motion: ReferenceMotion, row: int, stamp: int) -> Iterator[tuple[str, Json]]:
    qpos, qvel, joints = motion.qpos[row], motion.qvel[row], motion.joints
    when = {"sec": stamp // NANOSECONDS, "nsec": stamp % NANOSECONDS}
    yield (
        "/tf",
        {
            "transforms": [
                {
                    "timestamp": when,
                    "parent_frame_id": WORLD,
                    "child_frame_id": body,
                    "translation": _named(XYZ, motion.body_positions[row, place]),
                    "rotation": _named(XYZW, motion.body_quaternions[row, place][WXYZ]),
                }
                for place, body in enumerate(motion.bodies)
            ]
        },
    )
    yield (
        "/joints",
        {
            "angle": _named(joints, qpos[7:]),
            "rate": _named(joints, qvel[6:]),
            "torque": _named(joints, motion.torques[row]),
        },
    )
    yield (
        "/base",
        {
            "place": _named(XYZ, qpos[:3]),
            "turn": _named(XYZW, qpos[3:7][WXYZ]),
            "velocity": _named(XYZ, qvel[:3]),
            "angular_velocity": _named(XYZ, qvel[3:6]),
        },
    )
    feet = zip(motion.feet, motion.forces[row], motion.contacts[row], strict=True)
    yield "/feet", {foot: {"force": _named(XYZ, force), "stands": bool(down)} for foot, force, down in feet}
    yield "/gait", {"stance": motion.stances[row]}


def _named(names: Sequence[str], values: Vector) -> dict[str, float]:
    return dict(zip(names, map(float, values), strict=True))


def _schemas(motion: ReferenceMotion) -> dict[str, tuple[str, Json]]:
    """Topic -> name of its schema, and the schema."""
    place, turn, joints = _numbers(XYZ), _numbers(XYZW), _numbers(motion.joints)
    stamp = _object({"sec": {"type": "integer"}, "nsec": {"type": "integer"}})
    text: Json = {"type": "string"}
    transform = _object(
        {
            "timestamp": stamp,
            "parent_frame_id": text,
            "child_frame_id": text,
            "translation": place,
            "rotation": turn,
        }
    )
    base = {"place": place, "turn": turn, "velocity": place, "angular_velocity": place}
    foot = _object({"force": place, "stands": {"type": "boolean"}})
    return {
        "/tf": ("foxglove.FrameTransforms", _object({"transforms": {"type": "array", "items": transform}})),
        "/joints": ("amble.Joints", _object({"angle": joints, "rate": joints, "torque": joints})),
        "/base": ("amble.Base", _object(base)),
        "/feet": ("amble.Feet", _object(dict.fromkeys(motion.feet, foot))),
        "/gait": ("amble.Gait", _object({"stance": text})),
    }


def _numbers(names: Sequence[str]) -> Json:
    return _object({name: {"type": "number"} for name in names})


def _object(properties: dict[str, Json]) -> Json:
    return {"type": "object", "properties": properties, "required": list(properties)}
