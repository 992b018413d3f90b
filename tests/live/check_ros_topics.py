"""Reads the ROS 2 messages of a sampled walk and decodes them with rosbags.

    check_ros_topics.py INSTANCE

Waits for the instance, reads until it has ended, and fails where a message is not what the set-point
says.
"""

import ctypes
import pathlib
import sys
import time

import iceoryx2 as iox
from rosbags.typesys import Stores, get_typestore

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "tools" / "mirrors"))
import surefoot_instances as instances  # noqa: E402

WAIT_SECONDS = 60.0
POLL_SECONDS = 0.001
TOPICS = {
    "joint_states": "sensor_msgs/msg/JointState",
    "tf": "tf2_msgs/msg/TFMessage",
    "joint_trajectory": "trajectory_msgs/msg/JointTrajectory",
    "root_trajectory": "trajectory_msgs/msg/MultiDOFJointTrajectory",
}


class RosHeader(ctypes.Structure):
    """The user header that iceoryx2's ROS 2 gateway expects."""

    _fields_ = [
        ("gid", ctypes.c_uint8 * 16),
        ("source_timestamp_ns", ctypes.c_int64),
        ("sequence_number", ctypes.c_uint64),
    ]

    @staticmethod
    def type_name():
        return "RosHeader"


def byte_of(ros_type):
    """A byte with the type name of a ROS 2 message."""
    fields = {"_fields_": [("byte", ctypes.c_uint8)], "type_name": staticmethod(lambda: ros_type)}
    return type("Byte", (ctypes.Structure,), fields)


def wait_for(make):
    deadline = time.monotonic() + WAIT_SECONDS
    while True:
        try:
            return make()
        except Exception:
            if time.monotonic() > deadline:
                raise
            time.sleep(POLL_SECONDS)


def subscribe(node, topic, ros_type):
    name = iox.ServiceName.new(f"ros2://topics/{topic}")
    builder = node.service_builder(name).publish_subscribe(iox.Slice[byte_of(ros_type)])
    service = builder.user_header(RosHeader).open()
    return service, service.subscriber_builder().buffer_size(8).create()


def main():
    iox.set_log_level(iox.LogLevel.Fatal)
    instance = wait_for(lambda: instances.find(sys.argv[1]))
    builder = iox.NodeBuilder.new().config(instance.config())
    builder = builder.signal_handling_mode(iox.SignalHandlingMode.Disabled)
    node = builder.create(iox.ServiceType.Ipc)
    ports = {
        topic: wait_for(lambda: subscribe(node, topic, ros_type))
        for topic, ros_type in TOPICS.items()
    }
    print("attached", flush=True)
    store = get_typestore(Stores.ROS2_HUMBLE)
    received = {topic: [] for topic in TOPICS}
    while True:
        attended = ports["tf"][0].dynamic_config.number_of_publishers > 0
        for topic, (_, subscriber) in ports.items():
            while (sample := subscriber.receive()) is not None:
                payload = sample.payload()
                raw = ctypes.string_at(payload.data_ptr, payload.number_of_elements)
                header = sample.user_header().contents
                received[topic].append((header.sequence_number, store.deserialize_cdr(raw, TOPICS[topic])))
                sample.delete()
        if not attended and received["tf"]:
            break
        time.sleep(POLL_SECONDS)
    check(received)
    print({topic: len(messages) for topic, messages in received.items()})


def check(received):
    for topic, messages in received.items():
        numbers = [number for number, _ in messages]
        assert numbers == sorted(set(numbers)) and numbers, topic
    names = received["joint_states"][0][1].name
    for _, state in received["joint_states"]:
        assert len(state.position) == len(state.velocity) == len(state.effort) == len(names)
    for _, trajectory in received["joint_trajectory"]:
        assert trajectory.joint_names == names
        times = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in trajectory.points]
        assert times[0] == 0.0 and times == sorted(times)
    for _, tf in received["tf"]:
        frame = tf.transforms[0]
        assert frame.header.frame_id == "world" and frame.header.stamp.sec > 1_600_000_000


if __name__ == "__main__":
    main()
