"""Measure how a press is shown, beside other ways to show it: `python3 dev.py bench --show`."""

from __future__ import annotations

import json
import statistics
import sys
import tempfile
from pathlib import Path

from tests.bench.enabling import INSTALL, in_blender
from tools.environment import ROOT
from tools.extension import build_zip

# a square grid that is moved up and down, each way in turn, hidden while the others are measured: by the modifier that
# ships; by one that gives a copy of the mesh, whose coordinates or shape key are written; and in the mesh itself
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
class Seeing(bpy.types.RenderEngine):
    bl_idname, bl_label = 'SEEING', 'Seeing'
    def render(self, graph):
        for way, obj in ways.items():
            vertices = obj.evaluated_get(graph).data.vertices
            moved[way] = max(abs(vertex.undeformed_co.z) for vertex in vertices)
bpy.utils.register_class(Seeing)
scene, found, moved = bpy.context.scene, [], {}
scene.render.engine, scene.render.resolution_percentage = 'SEEING', 1
scene.camera = bpy.data.objects.new('Camera', bpy.data.cameras.new('Camera'))
for side, shading in ((100, 'flat'), (100, 'smooth'), (316, 'flat'), (316, 'smooth')):
    def grid(name):
        before = set(bpy.data.objects)
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=side - 1, y_subdivisions=side - 1)
        (made,) = set(bpy.data.objects) - before
        made.data.name = name
        made.data.polygons.foreach_set('use_smooth', [shading == 'smooth'] * len(made.data.polygons))
        return made
    ways = {way: grid(way) for way in ('modifier', 'copy', 'key', 'mesh')}
    written = {'mesh': ways['mesh'].data}
    for way in ('copy', 'key'):
        written[way] = ways[way].data.copy()
        carrier = bpy.data.objects.new(way, written[way])
        if way == 'key':
            carrier.shape_key_add(name='Pressed')
            written[way] = written[way].shape_keys
        group = bpy.data.node_groups.new(way, 'GeometryNodeTree')
        group.interface.new_socket('Geometry', in_out='OUTPUT', socket_type='NodeSocketGeometry')
        info, result = group.nodes.new('GeometryNodeObjectInfo'), group.nodes.new('NodeGroupOutput')
        info.inputs['Object'].default_value = carrier
        group.links.new(info.outputs['Geometry'], result.inputs[0])
        ways[way].modifiers.new(way, 'NODES').node_group = group
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
                if way == 'key':
                    written[way].key_blocks[0].points.foreach_set('co', rest + shown)
                else:
                    written[way].attributes['position'].data.foreach_set('vector', rest + shown)
                written[way].update_tag()
            bpy.context.view_layer.update()
            done = [time.process_time()]
            mesh = evaluated(obj)
            (mesh.vertex_normals if shading == 'smooth' else mesh.polygon_normals)[0].vector
            mesh.calc_loop_triangles()
            mesh.edges[0].is_loose
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
    assert all(np.array_equal(end, ends[0]) for end in ends) and (ends[0] != rest).any()
    for obj in ways.values():
        obj.hide_render = False
    bpy.ops.render.render()
    names = {way: evaluated(obj).name for way, obj in ways.items()}
    found.append((len(rest) // 3, shading, took))
    bpy.data.batch_remove([*ways.values(), *(obj.data for obj in ways.values())])
print('took', json.dumps((found, names, moved)))
"""
STAGES = "evaluated", "and ready to draw", "and drawn"
TURNS = 42  # of which the first two are not counted


def main() -> int:
    path = build_zip(sys.executable, Path(ROOT) / "build")
    with tempfile.TemporaryDirectory(prefix="dimple-") as profile:
        in_blender(INSTALL.format(str(path)), profile)
        output = in_blender(IN_BLENDER.replace("TURNS", str(TURNS)), profile)
    found, names, moved = json.loads(output.partition("took ")[2].partition("\n")[0])
    version = output.rpartition("in ")[2].strip()
    print(f"Blender {version}, ms of processor time a frame (times that of writing the mesh):")
    for vertices, shading, took in found:
        print(f"{vertices:,} vertices, {shading}:")
        for number, stage in enumerate(STAGES):
            plain = took["mesh"][number][2:]
            words = [f"{way} {_against(times[number][2:], plain)}" for way, times in took.items()]
            print(f"  {stage}: {', '.join(words)}")
    print(f"The mesh that an exporter sees: {', '.join(f'{way} {name!r}' for way, name in names.items())}")
    print(f"How far Generated coordinates move: {', '.join(f'{way} {far:.3f}' for way, far in moved.items())}")
    return 0


def _against(times: list[float], plain: list[float]) -> str:
    """Return the median of some times, and that of their ratios to those of the mesh in the same turns."""
    ratio = statistics.median(a / b for a, b in zip(times, plain, strict=True))
    return f"{statistics.median(times):.2f} ({ratio:.2f})"
