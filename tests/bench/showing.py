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

# a square grid that is moved up and down, each way in turn; the evaluation is what Blender does before it draws
IN_BLENDER = """
import json
import numpy as np
addon_utils.enable('bl_ext.user_default.dimple')
from bl_ext.user_default.dimple.operators import offset
found = {}
for side in (100, 316):
    def grid(name):
        before = set(bpy.data.objects)
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=side - 1, y_subdivisions=side - 1)
        (made,) = set(bpy.data.objects) - before
        return made
    ways = {'modifier': grid('Modifier'), 'mesh': grid('Mesh')}
    rest = np.empty(3 * len(ways['mesh'].data.vertices), np.float32)
    ways['mesh'].data.attributes['position'].data.foreach_get('vector', rest)
    took = {way: [] for way in ways}
    for turn in range(TURNS):
        for way, obj in ways.items():
            shown = np.zeros_like(rest)
            shown[2::3] = 0.01 * (turn % 7)
            bpy.context.view_layer.update()
            started = time.process_time()
            if way == 'modifier':
                offset.show(obj, shown.reshape(-1, 3))
            else:
                obj.data.attributes['position'].data.foreach_set('vector', rest + shown)
                obj.data.update_tag()
            bpy.context.view_layer.update()
            took[way].append(1000 * (time.process_time() - started))
    graph, ends = bpy.context.evaluated_depsgraph_get(), []
    for obj in ways.values():
        ends.append(np.empty_like(rest))
        obj.evaluated_get(graph).data.attributes['position'].data.foreach_get('vector', ends[-1])
    assert np.array_equal(*ends) and (ends[0] != rest).any()
    found[len(rest) // 3] = took
    for obj in ways.values():
        bpy.data.objects.remove(obj)
print('took', json.dumps(found))
"""
TURNS = 62  # of which the first two are not counted


def main() -> int:
    path = build_zip(sys.executable, Path(ROOT) / "build")
    with tempfile.TemporaryDirectory(prefix="dimple-") as profile:
        in_blender(INSTALL.format(str(path)), profile)
        output = in_blender(IN_BLENDER.replace("TURNS", str(TURNS)), profile)
    took = json.loads(output.partition("took ")[2].partition("\n")[0])
    print(f"Blender {output.rpartition('in ')[2].strip()}, ms of processor time a frame, evaluation included:")
    for vertices, ways in took.items():
        modifier, mesh = (statistics.median(ways[way][2:]) for way in ("modifier", "mesh"))
        times = statistics.median(a / b for a, b in zip(ways["modifier"][2:], ways["mesh"][2:], strict=True))
        print(f"{int(vertices):,} vertices: modifier {modifier:.2f}, writing the mesh {mesh:.2f}, {times:.1f} times")
    return 0
