"""Render the pictures of docs/blender.md in Blender, which does what the page says: ``make blender-pictures`` runs it.

It needs bpy, and the extension's zip: it is installed into an empty home, as a reader would.
"""

from __future__ import annotations

import math
import os
import sys
import tempfile
from pathlib import Path

HOME = tempfile.mkdtemp(prefix="blender-home-")
os.environ.update(HOME=HOME, BLENDER_USER_RESOURCES=HOME)

import bpy  # noqa: E402
import numpy as np  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "docs" / "images" / "blender"
CLIP = ROOT / "src" / "retime" / "data" / "sample.bvh"
# Seconds between two figures of a strip, and metres.
EVERY, APART = 0.75, 0.9
WIDTH, HEIGHT = 1100, 210
# It walks away from the camera: seen from the side.
ANGLE = math.radians(-65)
TURN = np.array([[math.cos(ANGLE), -math.sin(ANGLE), 0], [math.sin(ANGLE), math.cos(ANGLE), 0], [0, 0, 1]])
INK, BLUE, GREY = (0.05, 0.06, 0.08), (0.05, 0.25, 0.75), (0.55, 0.57, 0.6)


def material(name, colour):
    """Make a material that is a plain colour in any light."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    glow, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    glow.inputs["Color"].default_value = (*colour, 1.0)
    links.new(glow.outputs["Emission"], out.inputs["Surface"])
    return made


def tube(scene, lines, thickness, paint):
    """Draw polylines, (n, 3) each, as one tube."""
    curve = bpy.data.curves.new("lines", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.use_fill_caps = "3D", thickness, True
    for line in lines:
        spline = curve.splines.new("POLY")
        spline.points.add(len(line) - 1)
        spline.points.foreach_set("co", np.concatenate([line, np.ones((len(line), 1))], axis=1).ravel())
    one = bpy.data.objects.new("lines", curve)
    curve.materials.append(paint)
    scene.collection.objects.link(one)


def text(scene, words, place, size, paint, align="CENTER"):
    """Write words, to be read from the front."""
    made = bpy.data.curves.new("words", "FONT")
    made.body, made.size, made.align_x = words, size, align
    made.materials.append(paint)
    one = bpy.data.objects.new("words", made)
    one.location, one.rotation_euler = place, (math.pi / 2, 0, 0)
    scene.collection.objects.link(one)


def studio(name, low, high, height):
    """Make a scene that a camera sees from the front, from x = low to high, in orthographic view."""
    scene = bpy.data.scenes.new(name)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", high - low
    camera.location, camera.rotation_euler = ((low + high) / 2, -20, height), (math.pi / 2, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 12, False
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.compression = 100
    return scene


def shoot(scene, name, width=WIDTH, height=HEIGHT):
    """Render a scene into the docs."""
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.filepath = str(OUT / f"{name}.png")
    bpy.ops.render.render(write_still=True, scene=scene.name)


def strip(rig, last, name, columns):
    """Render the rig every so many frames, side by side, with the seconds below."""
    scene = bpy.context.scene
    rate = scene.render.fps / scene.render.fps_base
    figures = []
    for k in range(int((last - 1) / rate / EVERY) + 1):
        frame = 1 + k * EVERY * rate
        scene.frame_set(math.floor(frame), subframe=frame - math.floor(frame))
        bones = rig.evaluated_get(bpy.context.evaluated_depsgraph_get()).pose.bones
        ends = [(bone.head, bone.tail) for bone in bones]
        ends += [(bone.parent.tail, bone.head) for bone in bones if bone.parent is not None]
        lines = np.array([[rig.matrix_world @ a, rig.matrix_world @ b] for a, b in ends])
        lines -= [*lines[0, 0, :2], 0.0]
        figures.append(lines @ TURN.T + [k * APART, 0, 0])
    room = studio(name, -0.7, (columns - 1) * APART + 0.7, 0.95)
    ink, grey, blue = material("ink", INK), material("grey", GREY), material("blue", BLUE)
    tube(room, [np.array([[-0.6, 0.3, -0.02], [(columns - 1) * APART + 0.6, 0.3, -0.02]])], 0.008, grey)
    for k, lines in enumerate(figures):
        tube(room, lines, 0.03, blue if name == "after" else ink)
        text(room, f"{k * EVERY:g} s", (k * APART, 0, -0.34), 0.22, ink)
    shoot(room, name)


def graph(to, at, rate):
    """Render the curve of the new timing beside an even one."""
    span = max(to[-1], at[-1])
    width, height = 8.0, 8.0 * at[-1] / to[-1] / 1.6
    points = np.stack([to / to[-1] * width, np.zeros(len(to)), at / at[-1] * height], axis=1)
    room = studio("curve", -1.0, width + 0.6, height / 2 - 0.1)
    ink, grey, blue = material("ink", INK), material("grey", GREY), material("blue", BLUE)
    lines = []
    for second in range(0, int(span / rate) + 1, 2):
        x, z = second * rate / to[-1] * width, second * rate / at[-1] * height
        if x <= width + 1e-6:
            lines.append(np.array([[x, 0.4, 0.0], [x, 0.4, height]]))
            text(room, f"{second} s", (x, 0, -0.35), 0.24, ink)
        if z <= height + 1e-6:
            lines.append(np.array([[0.0, 0.4, z], [width, 0.4, z]]))
            text(room, f"{second} s", (-0.12, 0, z - 0.08), 0.24, ink, align="RIGHT")
    tube(room, lines, 0.006, material("light", (0.8, 0.81, 0.83)))
    tube(room, [points[[0, -1]] + [0, 0.2, 0]], 0.015, grey)
    tube(room, [points], 0.035, blue)
    text(room, "the motion as it was", (0.15, 0, height - 0.3), 0.24, ink, align="LEFT")
    text(room, "new time", (width, 0, 0.12), 0.24, ink, align="RIGHT")
    shoot(room, "curve", 640, round(640 * (height + 1.1) / (width + 1.6)))


def main():
    """Do what the page says, and render what there is to be seen."""
    (zipped,) = [Path(name).resolve() for name in sys.argv[1:]]
    OUT.mkdir(parents=True, exist_ok=True)
    bpy.ops.extensions.package_install_files(filepath=str(zipped), repo="user_default", enable_on_install=True)
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.preferences.addon_enable(module="io_anim_bvh")
    # The clip is in centimetres.
    bpy.ops.import_anim.bvh(filepath=str(CLIP), global_scale=0.01, update_scene_fps=True, update_scene_duration=True)
    rig, scene = bpy.context.object, bpy.context.scene
    rate = scene.render.fps / scene.render.fps_base
    columns = int((scene.frame_end - 1) / rate / EVERY) + 1
    strip(rig, scene.frame_end, "before", columns)
    scene.retime.search_length = "65%"
    bpy.ops.retime.retime()
    print(scene.retime.summary)
    strip(rig, scene.frame_end, "after", columns)
    animation = scene.animation_data
    bags = (
        [strip.channelbag(animation.action_slot) for layer in animation.action.layers for strip in layer.strips]
        if hasattr(animation.action, "layers")
        else [animation.action]
    )
    points = np.array([point.co for point in bags[0].fcurves[0].keyframe_points])
    graph(points[:, 0] - 1, points[:, 1] - 1, rate)


if __name__ == "__main__":
    main()
