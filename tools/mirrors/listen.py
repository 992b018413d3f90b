#!/usr/bin/env python3
"""Listens to a running walk and prints its chunks and where the robot is. Takes no part: nobody waits for it.

    pip install iceoryx2==0.10.0
    python3 tools/mirrors/listen.py [INSTANCE]

Without INSTANCE it takes the only one that runs. Messages are read where they lie in shared memory, without a copy.
"""

import argparse
import hashlib
import os
import pathlib
import sys
import time

import iceoryx2 as iox

import surefoot_messages as messages

MODES = ("left foot", "right foot", "both feet")
POLL_SECONDS = 0.0005
# What the services keep; see shared-types/src/instance/participant.rs.
CHUNKS_KEPT, STATES_KEPT = 8, 256


def root_of(name):
    """The folder of an instance, or of the only one."""
    base = pathlib.Path(f"/dev/shm/surefoot-{os.geteuid()}")
    running = sorted(folder.name for folder in base.iterdir()) if base.is_dir() else []
    if name is None and len(running) == 1:
        return base / running[0]
    if name in running:
        return base / name
    sys.exit(f"name one instance that runs; these do: {', '.join(running) or 'none'}")


def config_of(root):
    """iceoryx2's configuration for an instance: its own root path, and a prefix that only this user's instance has."""
    base = bytes(root.parent)
    tag = hashlib.sha256(len(base).to_bytes(8, "little") + base).hexdigest()[:12]
    config = iox.config.default()
    config.global_cfg.root_path = iox.Path.new(str(root))
    config.global_cfg.prefix = iox.FileName.new(f"surefoot-{tag}-{root.name}.")
    return config


def subscribe(node, name, role, message, kept):
    """A subscriber of one service, which must lay its messages out as our mirror does."""
    layout = iox.AttributeVerifier.new().require(iox.AttributeKey.new("surefoot.layout"), iox.AttributeValue.new(message.LAYOUT))
    builder = node.service_builder(iox.ServiceName.new(f"surefoot/{name}/{role}")).publish_subscribe(message)
    service = builder.open_with_attributes(layout)
    return service, service.subscriber_builder().buffer_size(kept).create()


def received(subscriber):
    """Every message that has come, each valid until the next one is asked for."""
    while (sample := subscriber.receive()) is not None:
        yield sample.payload().contents
        sample.delete()


def show_chunk(chunk):
    first, last = chunk.waypoints[0], chunk.waypoints[chunk.waypoints_len - 1]
    x, y, z = last.root_position
    print(
        f"chunk {chunk.sequence} of plan {chunk.plan_id}, epoch {chunk.epoch}: {chunk.waypoints_len} waypoints on "
        f"{MODES[chunk.mode]}, {first.time:.2f} to {last.time:.2f} s, root at {x:.3f} {y:.3f} {z:.3f}",
        flush=True,
    )


def show_state(state):
    x, y, z = state.centre_of_mass
    forces = ", ".join(f"{state.feet[index].force[2]:.0f} N" for index in range(state.feet_len))
    print(f"robot at {state.waypoint.time:.2f} s: centre of mass {x:.3f} {y:.3f} {z:.3f}, feet carry {forces}", flush=True)


def listen(name, states_every):
    root = root_of(name)
    iox.set_log_level(iox.LogLevel.Fatal)
    node = iox.NodeBuilder.new().config(config_of(root)).signal_handling_mode(iox.SignalHandlingMode.Disabled).create(iox.ServiceType.Ipc)
    service, chunks = subscribe(node, root.name, "chunks", messages.PlanChunk, CHUNKS_KEPT)
    try:
        _, states = subscribe(node, root.name, "state", messages.SimulationState, STATES_KEPT)
    except iox.PublishSubscribeOpenError:
        states = None  # Nobody walks with --rate here.
    print(f"listening to {root.name}", flush=True)
    heard, seen = False, 0
    while not heard or service.dynamic_config.number_of_publishers > 0:
        for chunk in received(chunks):
            heard = True
            show_chunk(chunk)
        for state in received(states) if states else ():
            if seen % states_every == 0:
                show_state(state)
            seen += 1
        time.sleep(POLL_SECONDS)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("instance", nargs="?", help="its name, as `surefoot monitor` lists it")
    parser.add_argument("--states-every", type=int, default=100, metavar="N", help="print one of N ticks (100: one a second)")
    arguments = parser.parse_args()
    try:
        listen(arguments.instance, arguments.states_every)
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
