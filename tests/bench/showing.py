"""Measure how a press is shown, beside writing it into the mesh: `python3 dev.py bench --show`."""

from __future__ import annotations

import json
import statistics
import sys
import tempfile
from pathlib import Path

from tests.bench.enabling import INSTALL, in_blender
from tools.environment import ROOT
from tools.extension import build_zip

# a square grid that is moved up and down, each way in turn, hidden while the other is measured
IN_BLENDER = """
import json
import gpu
import mathutils
import numpy as np
addon_utils.enable('bl_ext.user_default.dimple')
from bl_ext.user_default.dimple.operators import offset
gpu.init()
screen = gpu.types.GPUOffScreen(32, 32)
area = next(area for area in bpy.context.window.screen.areas if area.type == 'VIEW_3D')
region = next(region for region in area.regions if region.type == 'WINDOW')
area.spaces[0].overlay.show_overlays = False
above, near = mathutils.Matrix.Translation((0, 0, -5)), mathutils.Matrix.Diagonal((0.1, 0.1, -0.1, 1))
def draw():
    context = bpy.context
    screen.draw_view3d(context.scene, context.view_layer, area.spaces[0], region, above, near)
    screen.texture_color.read()
def evaluated(obj):
    return obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
for obj in list(bpy.data.objects):
    bpy.data.objects.remove(obj)
found = []
for side, shading in ((100, 'flat'), (100, 'smooth'), (316, 'flat'), (316, 'smooth')):
    def grid(name):
        before = set(bpy.data.objects)
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=side - 1, y_subdivisions=side - 1)
        (made,) = set(bpy.data.objects) - before
        made.data.polygons.foreach_set('use_smooth', [shading == 'smooth'] * len(made.data.polygons))
        return made
    ways = {'modifier': grid('Modifier'), 'mesh': grid('Mesh')}
    rest = np.empty(3 * len(ways['mesh'].data.vertices), np.float32)
    ways['mesh'].data.attributes['position'].data.foreach_get('vector', rest)
    took = {way: ([], [], []) for way in ways}
    for turn in range(TURNS):
        for way, obj in ways.items():
            for each in ways.values():
                each.hide_viewport = each != obj
            shown = np.zeros_like(rest)
            shown[2::3] = 0.01 * (turn % 7)
            draw()
            started = time.process_time()
            if way == 'modifier':
                offset.show(obj, shown.reshape(-1, 3))
            else:
                obj.data.attributes['position'].data.foreach_set('vector', rest + shown)
                obj.data.update_tag()
            bpy.context.view_layer.update()
            done = [time.process_time()]
            mesh = evaluated(obj)
            (mesh.vertex_normals if shading == 'smooth' else mesh.polygon_normals)[0].vector
            done.append(time.process_time())
            draw()
            done.append(time.process_time())
            for times, at in zip(took[way], done):
                times.append(1000 * (at - started))
    ends = []
    for obj in ways.values():
        obj.hide_viewport = False
        bpy.context.view_layer.update()
        ends.append(np.empty_like(rest))
        evaluated(obj).attributes['position'].data.foreach_get('vector', ends[-1])
    assert np.array_equal(*ends) and (ends[0] != rest).any()
    found.append((len(rest) // 3, shading, took))
    for obj in ways.values():
        bpy.data.objects.remove(obj)
print('took', json.dumps(found))
"""
STAGES = "evaluated", "and normals", "and drawn"
TURNS = 42  # of which the first two are not counted


def main() -> int:
    path = build_zip(sys.executable, Path(ROOT) / "build")
    with tempfile.TemporaryDirectory(prefix="dimple-") as profile:
        in_blender(INSTALL.format(str(path)), profile)
        output = in_blender(IN_BLENDER.replace("TURNS", str(TURNS)), profile)
    print(f"Blender {output.rpartition('in ')[2].strip()}, ms of processor time a frame:")
    for vertices, shading, took in json.loads(output.partition("took ")[2].partition("\n")[0]):
        print(f"{vertices:,} vertices, {shading}:")
        for stage, ours, plain in zip(STAGES, took["modifier"], took["mesh"], strict=True):
            modifier, mesh = statistics.median(ours[2:]), statistics.median(plain[2:])
            times = statistics.median(a / b for a, b in zip(ours[2:], plain[2:], strict=True))
            print(f"  {stage}: modifier {modifier:.2f}, writing the mesh {mesh:.2f}, {times:.2f} times")
    return 0
