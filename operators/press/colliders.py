"""Contact of running bodies: with objects that have Dimple Collider ticked, with each other, and with themselves.

Once an object of the scene is ticked, all running bodies of the same scale collide with it and with each other;
otherwise each body runs alone, at no extra cost.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from mathutils import Matrix

from ...core.base import DimpleError
from ...core.message import in_a_row
from ..bridge import body_model, final_mesh, object_link, sizing

if TYPE_CHECKING:
    from ...core.base import Floats, Ints
    from ...core.session import Session
    from ...core.world import World

SAME_SCALE = 1e-6  # relative difference up to which two scales count as the same
_APART = "Bodies of different scale do not collide: set Physical Size to As Modeled in Physics > Dimple."


@dataclass(slots=True, kw_only=True, eq=False)
class LiveWorld:
    """Bodies that are stepped together."""

    key: tuple[Any, ...]  # everything that it was made from; another key requires a new world
    uids: tuple[int, ...]  # session_uids of the bodies
    scale: float  # physical metres per scene unit
    colliders: tuple[str, ...]  # names of the objects
    # the colliders that fall, by index: session_uid, name, and matrix in the scene when the world was made
    props: dict[int, tuple[int, str, Matrix]]
    world: World  # steps them


def is_on(scene: bpy.types.Scene) -> bool:
    """Return whether contact is on: an object of the scene is a collider, or a body has self contact."""
    return any(obj.dimple.collider or (obj.dimple.enabled and obj.dimple.self_contact) for obj in scene.objects)


def worlds_of(
    context: bpy.types.Context,
    bodies: Mapping[int, tuple[bpy.types.Object, Session, float]],
    before: Sequence[LiveWorld] = (),
) -> list[LiveWorld]:
    """Return the worlds of the bodies; a world of `before` is reused if it is still valid.

    Args:
        bodies: object, session and scale of each body, by session_uid.

    Raises:
        DimpleError: two surfaces intersect, or a collider is not usable.
    """
    groups, on = _groups(bodies), is_on(context.scene)
    for _, session, _ in bodies.values():
        session.contact_note, session.held_note = _APART if on and len(groups) > 1 else "", ""
    if not on:
        return []
    graph = context.evaluated_depsgraph_get()
    colliders = [obj for obj in context.scene.objects if _is_collider(context.scene, graph, obj, bodies)]
    frictions = [(obj.session_uid, obj.dimple.collider_friction, _mass_of(obj)) for obj in colliders]
    found = []
    for scale, uids in groups.items():
        itself = [bool(bodies[uid][0].dimple.self_contact) for uid in uids]
        if not colliders and not any(itself) and len(uids) < 2:
            continue
        sessions = _moving([bodies[uid][1] for uid in uids])
        key = (scale, tuple(uids), tuple(itself), tuple(frictions), sessions)
        same = next((world for world in before if world.key == key), None)
        found.append(same or _make(context, key, scale, [bodies[uid] for uid in uids], colliders, itself))
        for uid, note in zip(uids, found[-1].world.notes, strict=True):
            bodies[uid][1].contact_note = in_a_row([note, bodies[uid][1].contact_note])
    return found


def lead_colliders(context: bpy.types.Context, live: LiveWorld) -> None:
    """Move the colliders of a world, by the end of the next step, to where their objects are now.

    Raises:
        DimpleError: an object is gone, or its number of vertices has changed.
    """
    graph = context.evaluated_depsgraph_get()
    live.world.gravity, live.world.ground = _pull(context.scene)
    ends = []
    for i, name in enumerate(live.colliders):
        if i in live.props:  # the simulation moves it
            ends.append(None)
            continue
        obj = context.scene.objects.get(name)
        if obj is None:
            raise DimpleError('Collider "{name}" is gone. Start again.', name=name)
        end = surface(graph, obj, live.scale)[0]
        same = end.shape == live.world.target(i).shape and np.array_equal(end, live.world.target(i))
        ends.append(None if same else end)
    live.world.set_colliders(ends)


def _is_collider(
    scene: bpy.types.Scene, graph: bpy.types.Depsgraph, obj: bpy.types.Object, bodies: Mapping[int, Any]
) -> bool:
    return (
        obj.dimple.collider
        and obj.type == "MESH"
        and obj.session_uid not in bodies
        and obj.evaluated_get(graph).is_evaluated  # else it is disabled in viewports, and its position is not updated
        and obj not in sizing.fingertips(scene)
    )


def _groups(bodies: Mapping[int, tuple[bpy.types.Object, Session, float]]) -> dict[float, list[int]]:
    """Return the uids of the bodies by scale: only bodies of the same scale can collide."""
    groups: dict[float, list[int]] = {}
    for uid, (_, _, scale) in bodies.items():
        near = next((other for other in groups if abs(other - scale) <= SAME_SCALE * scale), scale)
        groups.setdefault(near, []).append(uid)
    return groups


def _moving(sessions: Sequence[Session]) -> tuple[tuple[int, int], ...]:
    """Return the identities of sessions and of their simulated meshes: a new mesh may intersect something."""
    return tuple((id(session), id(session.body.model.mesh)) for session in sessions)


def _mass_of(obj: bpy.types.Object) -> float | None:
    """Return the mass of a prop [kg], None for a collider that follows its object."""
    return obj.dimple.prop_mass_kg if obj.dimple.is_prop else None


def _pull(scene: bpy.types.Scene) -> tuple[Floats, float | None]:
    """Return the gravity (3,) [m/s2] and the height of the ground [m] for props, None without a ground."""
    return np.array(body_model.gravity(scene)), 0.0 if scene.dimple.use_ground else None


def _make(
    context: bpy.types.Context,
    key: tuple[Any, ...],
    scale: float,
    bodies: Sequence[tuple[bpy.types.Object, Session, float]],
    colliders: Sequence[bpy.types.Object],
    itself: Sequence[bool],
) -> LiveWorld:
    from ...core.world import Collider, World, drop_proxies

    graph, made = context.evaluated_depsgraph_get(), []
    for obj in colliders:
        points, triangles = surface(graph, obj, scale)
        if not len(triangles) or not np.isfinite(points).all():
            raise DimpleError(
                'Collider "{name}" has no faces, or a coordinate that is not a number. Repair it, or switch '
                "Dimple Collider off.",
                name=obj.name,
            )
        made.append(Collider(points.T.copy(), triangles, obj.dimple.collider_friction))
    for (_, session, _), meets in zip(bodies, itself, strict=True):
        if meets and session.proxy is not None:  # the cells of a proxy may bridge a fold
            session.change(session.model, proxy=None)
    names = [obj.name for obj, _, _ in bodies] + [obj.name for obj in colliders]
    props = [(i, obj) for i, obj in enumerate(colliders) if obj.dimple.is_prop]
    falling = {i: (obj.session_uid, obj.name, obj.matrix_world.copy()) for i, obj in props}
    running = [session for _, session, _ in bodies]
    notes = drop_proxies(running, made, names)
    gravity, ground = _pull(context.scene)
    masses = list(map(_mass_of, colliders))
    world = World(running, made, masses=masses, gravity=gravity, ground=ground, itself=itself, names=names)
    world.notes = [in_a_row(each) for each in zip(notes, world.notes, strict=True)]
    key = (*key[:-1], _moving(running))
    uids, colliding = tuple(obj.session_uid for obj, _, _ in bodies), tuple(obj.name for obj in colliders)
    return LiveWorld(key=key, uids=uids, scale=scale, colliders=colliding, props=falling, world=world)


def surface(graph: bpy.types.Depsgraph, obj: bpy.types.Object, scale: float) -> tuple[Floats, Ints]:
    """Return the vertices (m, 3) [m] of an object, with its modifiers applied, and its triangles (t, 3)."""
    evaluated = obj.evaluated_get(graph)
    triangles, _ = final_mesh.triangles_of(evaluated.data)
    points = final_mesh.points_of(evaluated.data)
    return object_link.to_physical(scale, np.array(evaluated.matrix_world), points), triangles.astype(np.int64)
