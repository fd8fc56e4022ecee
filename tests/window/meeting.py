"""Two soft balls of 5,000 vertices in the window test: one falls on the other, and the window goes on being drawn."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import bpy
import numpy as np
import robot

Check = Callable[..., None]
CELLS, SIDES = 29, ((0, 1, 2), (1, 2, 0), (2, 0, 1))  # squares along an edge of the cube that a ball is made of
FRAME_S, FRAMES, DRAWS = 1 / 60, 60, 40


def meet(out: Path, check: Check, measured: dict) -> robot.Waits:
    """Let a ball fall on another one by Play, all settings as they are, and say what a frame takes."""
    others = list(bpy.context.selected_objects)
    for other in others:
        other.hide_set(True)
        other.select_set(False)
    floor = _add("Floor", np.array([(-3, -3, -1.02), (3, -3, -1.02), (3, 3, -1.02), (-3, 3, -1.02)]), [(0, 1, 2, 3)])
    floor.dimple.collider = True
    balls = [_add(name, *_ball((0.1 * k, 0.0, 2.03 * k))) for k, name in enumerate(("Lower", "Upper"))]
    for ball in balls:
        ball.dimple.pinned = False
        ball.dimple.size_mode = "CUSTOM"
        ball.select_set(True)
    bpy.context.view_layer.objects.active = balls[0]
    falls, bpy.context.scene.dimple.use_gravity = bpy.context.scene.dimple.use_gravity, True
    view = robot.area().spaces.active.region_3d
    seen = view.view_location.copy(), view.view_distance
    view.view_location, view.view_distance = (0.0, 0.0, 1.0), 7.0
    yield from robot.redrawn()
    running, live = robot.extension("operators.press.sessions"), robot.extension("operators.press.live_step")
    advance, drawing, steps, draws = live.advance, [0.0], [], []

    def timed(*given: object, **named: object) -> object:
        began = time.process_time()
        messages = advance(*given, **named)
        steps.append(time.process_time() - began)
        return messages

    hooks = [
        bpy.types.SpaceView3D.draw_handler_add(
            lambda: drawing.__setitem__(0, time.perf_counter()), (), "WINDOW", "PRE_VIEW"
        ),
        bpy.types.SpaceView3D.draw_handler_add(
            lambda: draws.append(time.perf_counter() - drawing[0]), (), "WINDOW", "POST_PIXEL"
        ),
    ]
    live.advance = timed
    with bpy.context.temp_override(window=robot.window(), area=robot.area(), region=robot.region()):
        bpy.ops.dimple.play("INVOKE_DEFAULT")
    yield from robot.until(lambda: len(running.sessions) == 2 and running.worlds, "both bodies run", 120)
    bodies = list(running.sessions.values())
    yield from robot.until(lambda: bodies[0].frame.time > 0.2, "they meet", 240)  # it has fallen 15 mm by 0.1 s
    began, simulated, drawn = time.perf_counter(), bodies[0].frame.time, robot.drawn()
    steps.clear(), draws.clear()
    yield from robot.until(lambda: robot.drawn() >= drawn + DRAWS, "the window is drawn", 240)
    wall = time.perf_counter() - began
    found = measured["meeting"] = {
        "vertices": [len(ball.data.vertices) for ball in balls],
        "frames_per_second": round((robot.drawn() - drawn) / wall, 1),
        "step_ms": round(1e3 * median(steps), 1), "draw_ms": round(1e3 * median(draws), 1),
        "real_time": round((bodies[0].frame.time - simulated) / wall, 2),
        "touching": running.worlds[0].world.meeting.touching,
    }  # fmt: skip
    robot.screenshot(out / "0-meeting.png")
    check("two bodies of 5,000 vertices touch in the window", found["touching"] > 0, _words(found))
    live.advance = advance
    for hook in hooks:
        bpy.types.SpaceView3D.draw_handler_remove(hook, "WINDOW")
    found |= _frames_of_60(live, bodies)
    # figures, not a verdict: another program on this computer takes their time too
    share = f"{found['in_time']:.0%} by the clock, {found['in_time_by_processor']:.0%} by processor time, "
    share += f"at {found['real_time_at_60']} of real time"
    whole = found["real_time_at_60"] > 0 and all(body.frame.finite for body in bodies)
    check(f"and of frames at 60 a second {share}, are done in time", whole, _words(found))
    yield from robot.key("ESC", *robot.on_screen((0.0, 0.0, 1.0)))
    yield from robot.until(lambda: not running.sessions, "ESC ends it", 60)
    for obj in (*balls, floor):
        bpy.data.meshes.remove(obj.data)
    bpy.context.scene.dimple.use_gravity = falls
    view.view_location, view.view_distance = seen
    for other in others:
        other.hide_set(False)
        other.select_set(True)
        bpy.context.view_layer.objects.active = other
    yield from robot.redrawn()


def _frames_of_60(live: object, bodies: list) -> dict[str, float]:
    """Step and evaluate frames as they are where drawing takes no time; what they take [ms]: wall, processor."""
    budget = bpy.context.scene.dimple.frame_budget_percent / 100 * FRAME_S
    spent, worked, evaluated, whole, begun = [], [], [], [], bodies[0].frame.time
    for _ in range(FRAMES):
        began, busy = time.perf_counter(), time.process_time()
        live.advance(bpy.context, FRAME_S, budget=budget)
        between = time.perf_counter()
        worked.append(time.process_time() - busy)
        bpy.context.view_layer.update()
        spent.append(between - began)
        evaluated.append(time.perf_counter() - between)
        whole.append(time.process_time() - busy)  # of all threads
    return {
        "step_at_60_ms": round(1e3 * median(spent), 1), "processor_ms": round(1e3 * median(worked), 1),
        "evaluation_ms": round(1e3 * median(evaluated), 1),
        "real_time_at_60": round((bodies[0].frame.time - begun) / (FRAMES * FRAME_S), 2),
        "in_time": round(float(np.mean([a + b < FRAME_S for a, b in zip(spent, evaluated, strict=True)])), 2),
        "in_time_by_processor": round(float(np.mean(np.array(whole) < FRAME_S)), 2),
    }  # fmt: skip


def _words(found: dict) -> str:
    return ", ".join(f"{name} {value}" for name, value in found.items())


def _ball(middle: tuple[float, float, float]) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """Return the vertices and squares of a cube that is blown up to a ball, of 6 CELLS^2 + 2 vertices."""
    along = np.tan(np.linspace(-np.pi / 4, np.pi / 4, CELLS + 1))
    u, v = (each.ravel() for each in np.meshgrid(along, along, indexing="ij"))
    grid = np.arange((CELLS + 1) ** 2).reshape(CELLS + 1, -1)
    square = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1).reshape(-1, 4)
    points, faces = [], []
    for turn in SIDES:
        for side in (-1.0, 1.0):
            faces.append((square if side > 0 else square[:, ::-1]) + len(points) * len(u))
            points.append(np.stack([u, v, np.full_like(u, side)], axis=1)[:, np.argsort(turn)])
    _, kept, same = np.unique(np.round(np.concatenate(points), 6), axis=0, return_index=True, return_inverse=True)
    x = np.concatenate(points)[kept]
    return x / np.linalg.norm(x, axis=1)[:, None] + middle, same.ravel()[np.concatenate(faces)].tolist()


def _add(name: str, points: np.ndarray, faces: list) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], faces)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    return obj
