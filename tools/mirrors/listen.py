#!/usr/bin/env python3
"""Prints the chunks of a running walk and the state of the robot.

    pip install iceoryx2==0.10.0
    python3 tools/mirrors/listen.py [INSTANCE]

Without INSTANCE it takes the only running one. It only subscribes: no process waits for it.
Messages are read in shared memory, without a copy.
"""

import argparse
import sys
import time

import iceoryx2 as iox

import surefoot_instances as instances
import surefoot_messages as messages

MODES = ("left foot", "right foot", "both feet")
POLL_SECONDS = 0.0005
# Buffer sizes of the services, as in shared-types/src/instance/tuning.rs.
CHUNKS_BUFFERED, STATES_BUFFERED = 8, 256


def subscribe(node, instance, role, message, buffered):
    """A service and a subscriber of it. The service must have the layout of our mirror."""
    key = iox.AttributeKey.new("surefoot.layout")
    layout = iox.AttributeVerifier.new().require(key, iox.AttributeValue.new(message.LAYOUT))
    service_name = iox.ServiceName.new(instance.service_name(role))
    builder = node.service_builder(service_name).publish_subscribe(message)
    service = builder.open_with_attributes(layout)
    return service, service.subscriber_builder().buffer_size(buffered).create()


def received(subscriber):
    """Every message that has arrived. Each is valid until the next one is requested."""
    while (sample := subscriber.receive()) is not None:
        yield sample.payload().contents
        sample.delete()


def show_chunk(chunk):
    first, last = chunk.waypoints[0], chunk.waypoints[chunk.waypoints_len - 1]
    x, y, z = last.root_position
    print(
        f"chunk {chunk.sequence} of plan {chunk.plan_id}, epoch {chunk.epoch}: "
        f"{chunk.waypoints_len} waypoints on {MODES[chunk.mode]}, "
        f"{first.time:.2f} to {last.time:.2f} s, root at {x:.3f} {y:.3f} {z:.3f}",
        flush=True,
    )


def show_state(state):
    x, y, z = state.centre_of_mass
    forces = ", ".join(f"{state.feet[index].force[2]:.0f} N" for index in range(state.feet_len))
    print(
        f"robot at {state.waypoint.time:.2f} s: centre of mass {x:.3f} {y:.3f} {z:.3f}, "
        f"feet carry {forces}",
        flush=True,
    )


def listen(name, states_every):
    try:
        instance = instances.find(name)
    except instances.InstanceError as error:
        sys.exit(str(error))
    iox.set_log_level(iox.LogLevel.Fatal)
    builder = iox.NodeBuilder.new().config(instance.config())
    builder = builder.signal_handling_mode(iox.SignalHandlingMode.Disabled)
    node = builder.create(iox.ServiceType.Ipc)
    service, chunks = subscribe(node, instance, "chunks", messages.PlanChunk, CHUNKS_BUFFERED)
    try:
        _, states = subscribe(
            node, instance, "state", messages.SimulationState, STATES_BUFFERED
        )
    except iox.PublishSubscribeOpenError:
        states = None  # The controller publishes states only with --rate.
    print(f"listening to {instance.name}", flush=True)
    has_chunk, states_received = False, 0
    while not has_chunk or service.dynamic_config.number_of_publishers > 0:
        for chunk in received(chunks):
            has_chunk = True
            show_chunk(chunk)
        for state in received(states) if states else ():
            if states_received % states_every == 0:
                show_state(state)
            states_received += 1
        time.sleep(POLL_SECONDS)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("instance", nargs="?", help="its name, as `surefoot monitor` lists it")
    parser.add_argument(
        "--states-every",
        type=int,
        default=100,
        metavar="N",
        help="print one of N ticks (100: one a second)",
    )
    arguments = parser.parse_args()
    try:
        listen(arguments.instance, arguments.states_every)
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
