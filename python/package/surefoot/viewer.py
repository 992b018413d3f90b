"""Plans in the viewer Rerun, through the package ``rerun-sdk``."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.checker import Checker, Loads, Margins
from surefoot.errors import NoPlan, ParameterError, missing
from surefoot.plans import FEET, Plan, Samples
from surefoot.world import World

APPLICATION = "surefoot"
TIMELINE = "plan_time"
RATE_HZ = 25.0
"""Configurations shown per second of the plan."""
FORCE_LENGTH = 0.001
"""Length of the arrow of a force, m/N."""
SKELETON_GREY = (176, 180, 188)
WORLD_BROWN = (150, 138, 120)
FOOT_COLOURS = ((66, 133, 244), (234, 120, 40))
ROUTE_GREEN = (40, 160, 90)
MASS_RED = (210, 40, 60)
FORCE_PURPLE = (150, 70, 200)


@dataclass(frozen=True)
class Recording:
    """What :func:`view` has shown or written."""

    path: Path | None
    """The file, if one was asked for."""
    seconds: float
    """Duration of the plan, s; 0 for a search without a plan."""


def view(
    plan: Plan | NoPlan,
    *,
    save: str | os.PathLike[str] | None = None,
    connect: str | None = None,
    rate_hz: float = RATE_HZ,
    world: World | None = None,
) -> Recording:
    """Shows a plan in Rerun: robot, world, guide route, footholds, support polygon, centre of
    mass with its projection, contact forces, and margins and torques over time.

    It starts the viewer; ``save`` writes a file (.rrd) instead, ``connect`` sends to a running
    viewer (``rerun+http://HOST:PORT/proxy``). Of a :class:`NoPlan` it shows how far the search
    came, in ``world``.

    Raises :class:`MissingPackage` without ``rerun-sdk``.
    """
    try:
        import rerun
    except ImportError:
        raise missing("rerun-sdk", "view") from None
    if not 0.0 < rate_hz < float("inf"):
        raise ParameterError(f"rate_hz is {rate_hz}; it must be positive", parameter="rate_hz")
    stream = rerun.RecordingStream(APPLICATION)
    path = Path(save) if save is not None else None
    if path is not None:
        stream.save(path)
    elif connect is not None:
        stream.connect_grpc(connect)
    else:
        stream.spawn()
    with stream:
        rerun.log("/", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        if isinstance(plan, NoPlan):
            _log_search(rerun, plan, world)
            seconds = 0.0
        else:
            _log_plan(rerun, plan, rate_hz)
            seconds = plan.duration
    stream.flush()
    return Recording(path, seconds)


def _log_plan(rerun: Any, plan: Plan, rate_hz: float) -> None:
    samples = plan.sample(rate_hz)
    checker = Checker(plan.robot)
    loads = checker.loads(plan, rate_hz)
    rerun.send_blueprint(_blueprint(rerun))
    _log_world(rerun, plan.world)
    _log_route(rerun, plan.route)
    _log_footholds(rerun, plan)
    _log_robot(rerun, plan, samples)
    _log_support(rerun, plan)
    _log_loads(rerun, plan, loads)
    _log_margins(rerun, checker.margins(plan))


def _blueprint(rerun: Any) -> Any:
    from rerun import blueprint

    return blueprint.Blueprint(
        blueprint.Horizontal(
            blueprint.Spatial3DView(name="walk", origin="/"),
            blueprint.Vertical(
                blueprint.TimeSeriesView(name="margins, m and rad", origin="/margins/length"),
                blueprint.TimeSeriesView(name="margins, shares", origin="/margins/share"),
                blueprint.TimeSeriesView(name="in use, shares", origin="/use"),
                blueprint.TimeSeriesView(name="torques, N m", origin="/torque"),
            ),
            column_shares=[2, 1],
        ),
        blueprint.TimePanel(timeline=TIMELINE, play_state="paused", state="collapsed"),
    )


def _log_world(rerun: Any, world: World) -> None:
    for at, mesh in enumerate(world.meshes()):
        shape = rerun.Mesh3D(
            vertex_positions=mesh.vertices,
            triangle_indices=mesh.faces,
            vertex_normals=_normals(mesh.vertices, mesh.faces),
            albedo_factor=WORLD_BROWN,
        )
        rerun.log(["world", f"{at} {mesh.name}"], shape, static=True)


def _log_route(rerun: Any, route: NDArray[np.float64]) -> None:
    if len(route):
        line = rerun.LineStrips3D([route], colors=[ROUTE_GREEN], radii=[0.01])
        rerun.log("guide_route", line, static=True)


def _log_footholds(rerun: Any, plan: Plan) -> None:
    steps = plan.footholds
    outlines = [
        _closed(step.position, step.rotation, _rim(plan, step.foot)) for step in steps
    ]
    colours = [FOOT_COLOURS[foot] for foot in steps.foot]
    labels = [f"{at} {step.foot}, {step.time:.1f} s" for at, step in enumerate(steps)]
    soles = rerun.LineStrips3D(
        outlines, colors=colours, radii=[0.004], labels=labels, show_labels=False
    )
    rerun.log("footholds", soles, static=True)


def _log_robot(rerun: Any, plan: Plan, samples: Samples) -> None:
    robot = plan.robot
    poses = robot.link_poses(samples.root_position, samples.root_rotation, samples.joints)
    names = robot.link_names
    for mesh in robot.link_meshes():
        entity = ["robot", mesh.name]
        shape = rerun.Mesh3D(
            vertex_positions=mesh.vertices,
            triangle_indices=mesh.faces,
            vertex_normals=_normals(mesh.vertices, mesh.faces),
            albedo_factor=SKELETON_GREY,
        )
        rerun.log(entity, shape, static=True)
        of_link = poses[:, names.index(mesh.name)]
        rerun.send_columns(
            "/".join(rerun.escape_entity_path_part(part) for part in entity),
            indexes=[rerun.TimeColumn(TIMELINE, duration=samples.time)],
            columns=rerun.Transform3D.columns(
                translation=of_link[:, :3], quaternion=of_link[:, 3:]
            ),
        )


def _log_support(rerun: Any, plan: Plan) -> None:
    """The support polygon at each change of the stance."""
    contacts = plan.waypoints.contacts
    changes = [0, *(1 + np.flatnonzero((contacts[1:] != contacts[:-1]).any(axis=1)))]
    for at in changes:
        time = plan.waypoints.time[max(0, at - 1)] if at else 0.0
        rerun.set_time(TIMELINE, duration=time)
        feet = [foot for foot in range(2) if contacts[at, foot]]
        corners = np.vstack([_standing(plan, foot, plan.waypoints.time[at]) for foot in feet])
        hull = corners[_hull(corners[:, :2])]
        line = rerun.LineStrips3D([np.vstack([hull, hull[:1]])], colors=[MASS_RED], radii=[0.006])
        rerun.log("support_polygon", line)


def _log_loads(rerun: Any, plan: Plan, loads: Loads) -> None:
    times = [rerun.TimeColumn(TIMELINE, duration=loads.time)]
    centre = loads.centre_of_mass
    rerun.send_columns(
        "centre_of_mass",
        indexes=times,
        columns=rerun.Points3D.columns(
            positions=centre, radii=np.full(len(centre), 0.03), colors=_same(MASS_RED, centre)
        ),
    )
    ground = np.nanmin(loads.pressure_centres[:, :, 2], axis=1)
    shadow = np.column_stack([centre[:, :2], ground])
    rerun.send_columns(
        "centre_of_mass_projection",
        indexes=times,
        columns=rerun.Points3D.columns(
            positions=shadow, radii=np.full(len(centre), 0.02), colors=_same(MASS_RED, centre)
        ),
    )
    for foot, name in enumerate(FEET):
        forces = np.nan_to_num(loads.forces[:, foot]) * FORCE_LENGTH
        origins = np.nan_to_num(loads.pressure_centres[:, foot])
        rerun.send_columns(
            f"contact_force/{name}",
            indexes=times,
            columns=rerun.Arrows3D.columns(
                vectors=forces, origins=origins, colors=_same(FORCE_PURPLE, forces)
            ),
        )
    _log_series(rerun, "use/torque", loads.time, loads.torque_use)
    _log_series(rerun, "use/friction", loads.time, loads.friction_use)
    for at, joint in enumerate(plan.joint_names):
        name = rerun.escape_entity_path_part(joint)
        _log_series(rerun, f"torque/{name}", loads.time, loads.torques[:, at])


def _log_margins(rerun: Any, margins: Margins) -> None:
    """A step for each chunk: its worst margin holds from its beginning to its end."""
    times = margins.time.ravel()
    for check, numbers in margins.of.items():
        unit = "share" if "torque" in check or check == "acceleration" else "length"
        measured = ~np.isnan(numbers)
        steps = np.repeat(numbers[measured], 2)
        at = times.reshape(-1, 2)[measured].ravel()
        _log_series(rerun, f"margins/{unit}/{check}", at, steps)


def _log_series(
    rerun: Any, entity: str, times: NDArray[np.float64], numbers: NDArray[np.float64]
) -> None:
    if not len(times):
        return  # An empty series would stretch the timeline over all times.
    rerun.send_columns(
        entity,
        indexes=[rerun.TimeColumn(TIMELINE, duration=times)],
        columns=rerun.Scalars.columns(scalars=numbers),
    )


def _log_search(rerun: Any, search: NoPlan, world: World | None) -> None:
    """How far a search came that found no plan."""
    if world is not None:
        _log_world(rerun, world)
    if len(search.tree):
        trees = rerun.LineStrips3D(list(search.tree), radii=[0.004])
        rerun.log("trees", trees, static=True)
    _log_route(rerun, search.route)
    if search.bottleneck is not None:
        place = rerun.Points3D([search.bottleneck], colors=[MASS_RED], radii=[0.05])
        rerun.log("bottleneck", place, static=True)
    rerun.log("outcome", rerun.TextDocument(str(search)), static=True)


def _same(colour: tuple[int, int, int], rows: NDArray[np.float64]) -> NDArray[np.uint8]:
    return np.tile(np.array(colour, np.uint8), (len(rows), 1))


def _rim(plan: Plan, foot: str) -> NDArray[np.float64]:
    return next(sole.polygon for sole in plan.robot.soles if sole.foot == foot)


def _standing(plan: Plan, foot: int, time: float) -> NDArray[np.float64]:
    """The supported corners of a foot in the world, where it stands at a time."""
    steps = plan.footholds
    placed = np.flatnonzero((steps.foot == foot) & (steps.time <= time))[-1]
    step = steps[int(placed)]
    return _closed(step.position, step.rotation, step.polygon)[:-1]


def _closed(
    position: NDArray[np.float64], rotation: NDArray[np.float64], polygon: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The corners of a polygon of the sole in the world, the first one again at the end."""
    flat = np.column_stack([polygon, np.zeros(len(polygon))])
    x, y, z, w = rotation
    axis = np.array([x, y, z])
    turned = flat + 2.0 * np.cross(axis, np.cross(axis, flat) + w * flat)
    corners = turned + position
    return np.vstack([corners, corners[:1]])


def _hull(points: NDArray[np.float64]) -> list[int]:
    """Indices of the convex hull of points in the plane, counter-clockwise [Andrew 1979]."""
    order = sorted(range(len(points)), key=lambda at: tuple(points[at]))

    def half(indices: list[int]) -> list[int]:
        chain: list[int] = []
        for at in indices:
            while len(chain) > 1 and _turn(points[chain[-2]], points[chain[-1]], points[at]) <= 0:
                chain.pop()
            chain.append(at)
        return chain[:-1]

    return half(order) + half(order[::-1])


def _turn(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _normals(vertices: NDArray[np.float64], faces: NDArray[np.uint32]) -> NDArray[np.float64]:
    """Normals of the vertices: the mean of their faces' by area."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    of_faces = np.cross(b - a, c - a)
    normals = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(normals, faces[:, corner], of_faces)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(lengths > 0.0, lengths, 1.0)
