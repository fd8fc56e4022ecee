"""Twins: two objects of one shape and two materials, which one press presses both."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import bpy
from mathutils import Matrix, Vector

from . import sessions

if TYPE_CHECKING:
    from ..core.session import Finger
    from .sessions import LiveBody

APART = 1.25  # of the width: between the middles of twins
Fingers = Sequence["Finger | None"]


def other(obj: bpy.types.Object, scene: bpy.types.Scene) -> bpy.types.Object | None:
    """Return the twin of an object in a scene: its original, or its copy."""
    found = obj.dimple.twin
    if found is None:
        found = next((each for each in scene.objects if each.dimple.twin == obj), None)
    return found if found and found.name in scene.objects and found != obj else None


def joined(bodies: Iterable[bpy.types.Object], scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """Return objects together with their twins, each once."""
    found = list(bodies)
    for obj in list(found):
        twin = other(obj, scene) if obj.type == "MESH" else None
        if twin and twin not in found:
            found.append(twin)
    return found


def shared(pressed: Mapping[int, Fingers], scene: bpy.types.Scene) -> dict[int, Fingers]:
    """Return the fingertips on each body, with those on one twin pressing the other at the same place too."""
    result = dict(pressed)
    for uid, fingers in pressed.items():
        pair = _pair(uid, scene) if any(fingers) else None
        if pair and not any(pressed.get(pair[1].link.uid, ())):
            result[pair[1].link.uid] = moved(fingers, *pair)
    return result


def source(body: LiveBody) -> LiveBody | None:
    """Return the body that a twin is a copy of, where it runs."""
    obj = bpy.data.objects.get(body.name)
    return sessions.get(obj.dimple.twin) if obj and obj.dimple.twin else None


def moved(fingers: Fingers, here: LiveBody, there: LiveBody) -> list[Finger | None]:
    """Return fingertips that press a body as others do its twin."""
    way = Matrix(there.matrix.tolist()) @ Matrix(here.matrix.tolist()).inverted()

    def at(place: tuple[float, float, float]) -> tuple[float, ...]:
        return tuple(there.link.scale * (way @ (Vector(place) / here.link.scale)))

    def placed(finger: Finger) -> Finger:
        inward = (way.to_3x3() @ Vector(finger.inward)).normalized()
        via = tuple(map(at, finger.via))
        return finger._replace(position=at(finger.position), inward=tuple(inward), via=via)

    return [finger and placed(finger) for finger in fingers]


def _pair(uid: int, scene: bpy.types.Scene) -> tuple[LiveBody, LiveBody] | None:
    """Return a body that runs and its twin, where that runs too."""
    body = sessions.sessions.get(uid)
    obj = bpy.data.objects.get(body.name) if body else None
    twin = sessions.get(other(obj, scene)) if obj else None
    return (body, twin) if body and twin else None
