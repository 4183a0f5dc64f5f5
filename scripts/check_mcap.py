#!/usr/bin/env python3
"""Checks a log of `reseflow rollout --mcap FILE` with readers that are not ours.

Every message must decode, schemas must be Foxglove's, time stamps must strictly increase on every topic, and clouds must
be one control tick (50 ms) apart within an episode. Exit code 0 when all holds.

    pip install mcap mcap-protobuf-support
    python3 scripts/check_mcap.py FILE.mcap [--tick-ms 50]
"""

import argparse
import json
import math
import sys
from collections import defaultdict

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

FOXGLOVE = {
    "/observation/points": "foxglove.PointCloud",
    "/tf": "foxglove.FrameTransforms",
    "/scene": "foxglove.SceneUpdate",
    "/contacts/markers": "foxglove.SceneUpdate",
    "/plan/poses": "foxglove.PosesInFrame",
    "/executed/poses": "foxglove.PosesInFrame",
}
JSON = ["/gripper/opening", "/contacts", "/measure", "/outcome"]


class Fault(Exception):
    """What is wrong with the log."""


def require(condition, fault):
    if not condition:
        raise Fault(fault)


def stamp_nanos(stamp):
    """Nanoseconds of a google.protobuf.Timestamp."""
    return stamp.seconds * 1_000_000_000 + stamp.nanos


def check_message(topic, log_time, message):
    """What must hold for a single decoded message."""
    if topic == "/observation/points":
        require(stamp_nanos(message.timestamp) == log_time, f"{topic}: stamp differs from the log time {log_time}")
        require(len(message.data) > 0, f"{topic}: an empty cloud at {log_time}")
        require(len(message.data) % message.point_stride == 0, f"{topic}: a cloud cut off at {log_time}")
        names = [field.name for field in message.fields]
        require(names == ["x", "y", "z", "red", "green", "blue", "alpha"], f"{topic}: unexpected fields {names}")
    elif topic == "/tf":
        children = [transform.child_frame_id for transform in message.transforms]
        require("gripper" in children, f"{topic}: no frame `gripper` among {children}")
        for transform in message.transforms:
            q = transform.rotation
            norm = math.hypot(q.x, q.y, q.z, q.w)
            require(abs(norm - 1) < 1e-6, f"{topic}: a quaternion of norm {norm} at {log_time}")
    elif topic == "/scene":
        ids = [entity.id for entity in message.entities]
        require(ids and len(ids) == len(set(ids)), f"{topic}: no bodies, or one name twice, at {log_time}: {ids}")


def check(path, tick_nanos):
    """Raises Fault, or returns the figures."""
    times, schemas = defaultdict(list), {}
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        require(summary is not None and summary.statistics is not None, "the file has no summary: it was not finished")
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            topic = channel.topic
            schemas[topic] = schema.name
            times[topic].append(message.log_time)
            if channel.message_encoding == "json":
                json.loads(message.data)
        for schema, channel, message, decoded in reader.iter_decoded_messages(
            topics=list(FOXGLOVE), log_time_order=False
        ):
            check_message(channel.topic, message.log_time, decoded)

    count = sum(map(len, times.values()))
    require(count == summary.statistics.message_count, "the summary counts other messages than there are")
    for topic, name in FOXGLOVE.items():
        require(topic in times, f"no message on {topic}")
        require(schemas[topic] == name, f"{topic} has schema {schemas[topic]}, expected {name}")
    for topic in JSON:
        require(topic in times, f"no message on {topic}")
    for topic, stamps in times.items():
        backwards = [late for early, late in zip(stamps, stamps[1:]) if late <= early]
        require(not backwards, f"{topic}: time does not increase at {backwards[:1]}")
    clouds = times["/observation/points"]
    # An episode ends with its outcome; the next one begins a while later.
    ends = set(times["/outcome"])
    spacing = [late - early for early, late in zip(clouds, clouds[1:]) if early not in ends]
    odd = sorted({step for step in spacing if step != tick_nanos})
    require(not odd, f"clouds are {odd} ns apart, expected {tick_nanos}")
    return {
        "messages": count,
        "episodes": len(ends),
        "clouds": len(clouds),
        "cloud_spacing_ms": [min(spacing, default=0) / 1e6, max(spacing, default=0) / 1e6],
        "seconds": (max(map(max, times.values())) - min(map(min, times.values()))) / 1e9,
        "topics": {topic: {"schema": schemas[topic], "messages": len(times[topic])} for topic in sorted(times)},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--tick-ms", type=float, default=50.0, help="length of a control tick (default: 50)")
    options = parser.parse_args()
    try:
        figures = check(options.file, round(options.tick_ms * 1e6))
    except Fault as fault:
        sys.exit(f"{options.file}: {fault}")
    print(json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
