"""Checks a recording with the libraries of MCAP and ROS 2 bags.

    check_mcap.py WALK.mcap CONTACTS.json

CONTACTS.json is the contact sequence at the same rate.
"""

import json
import pathlib
import sys

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader


def by_topic_of_mcap(path):
    """The messages of each topic as mcap-ros2-support decodes them, and the topics' types."""
    messages, types = {}, {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            messages.setdefault(channel.topic, []).append((message.log_time, decoded))
            types[channel.topic] = schema.name
        assert summary.statistics.message_count == sum(len(m) for m in messages.values())
        names = [record.name for record in reader.iter_metadata()]
        assert names == ["surefoot"], names
    return messages, types


def check_rosbags(path, messages):
    """rosbags reads the same numbers."""
    with AnyReader([pathlib.Path(path)]) as reader:
        counts = {}
        positions = []
        for connection, time, raw in reader.messages():
            decoded = reader.deserialize(raw, connection.msgtype)
            counts[connection.topic] = counts.get(connection.topic, 0) + 1
            if connection.topic == "/joint_states":
                positions.append((time, decoded.position))
    assert counts == {topic: len(own) for topic, own in messages.items()}
    for (time, position), (other_time, other) in zip(positions, messages["/joint_states"]):
        assert time == other_time and np.array_equal(position, other.position)


def check_states(messages, sequence):
    """The state is that of the contact sequence."""
    knots = sequence["knots"]
    joints = sequence["robot"]["joint_names"]
    states = [state for _, state in messages["/joint_states"]]
    assert len(states) == len(knots) == len(messages["/tf"])
    roots = [tf.transforms[0] for _, tf in messages["/tf"]]
    centres = [centre.point for _, centre in messages["/centre_of_mass"]]
    for knot, state, root, centre in zip(knots, states, roots, centres):
        assert state.name[: len(joints)] == joints
        assert np.array_equal(state.position[: len(joints)], knot["q"])
        assert root.header.frame_id == "world"
        assert root.child_frame_id == sequence["robot"]["root_link"]
        translation = root.transform.translation
        assert [translation.x, translation.y, translation.z] == knot["root_pose"]["xyz"]
        assert np.allclose([centre.x, centre.y, centre.z], knot["com"], atol=1e-9)


def main():
    messages, types = by_topic_of_mcap(sys.argv[1])
    sequence = json.loads(pathlib.Path(sys.argv[2]).read_text(encoding="utf-8"))
    assert types["/joint_trajectory"] == "trajectory_msgs/msg/JointTrajectory"
    assert types["/root_trajectory"] == "trajectory_msgs/msg/MultiDOFJointTrajectory"
    assert types["/tf"] == types["/tf_static"] == "tf2_msgs/msg/TFMessage"
    assert types["/world_markers"] == "visualization_msgs/msg/MarkerArray"
    assert types["/scene"] == "foxglove_msgs/msg/SceneUpdate"
    assert types["/frame_transforms"] == "foxglove_msgs/msg/FrameTransforms"
    assert "<robot" in messages["/robot_description"][0][1].data
    check_states(messages, sequence)
    check_rosbags(sys.argv[1], messages)


main()
