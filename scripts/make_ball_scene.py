#!/usr/bin/env python3
"""Makes a scene of any number of triangles that always looks the same: a bumpy ball on a ground, seen by a camera.

    make_ball_scene.py OUT.glb TRIANGLES
"""

import array
import json
import math
import pathlib
import struct
import sys

RADIUS = 0.7
BUMP = 0.06  # of the radius
GROUND = 3.0  # half a side


def surface(u, v):
    """A point of the ball, u around and v from pole to pole, both in [0, 1]."""
    theta, phi = math.pi * v, 2 * math.pi * u
    r = RADIUS * (1 + BUMP * math.sin(5 * theta) * math.sin(4 * phi))
    return (r * math.sin(theta) * math.cos(phi), RADIUS + r * math.cos(theta), r * math.sin(theta) * math.sin(phi))


def grid(columns, rows, point, flip):
    """Positions and triangles of a grid over [0, 1]²."""
    positions, triangles = array.array("f"), array.array("I")
    for j in range(rows + 1):
        for i in range(columns + 1):
            positions.extend(point(i / columns, j / rows))
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            b, c, d = a + 1, a + columns + 1, a + columns + 2
            triangles.extend((a, b, c, b, d, c) if flip else (a, c, b, b, c, d))
    return positions, triangles


def add_mesh(gltf, data, positions, triangles):
    accessor = len(gltf["accessors"])
    for raw, target in ((positions, 34962), (triangles, 34963)):
        gltf["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(data), "byteLength": len(raw) * raw.itemsize, "target": target})
        data.extend(raw.tobytes())
    view = len(gltf["bufferViews"]) - 2
    axes = [positions[k::3] for k in range(3)]
    gltf["accessors"] += [
        {"bufferView": view, "componentType": 5126, "count": len(positions) // 3, "type": "VEC3",
         "min": [min(a) for a in axes], "max": [max(a) for a in axes]},
        {"bufferView": view + 1, "componentType": 5125, "count": len(triangles), "type": "SCALAR"}]
    gltf["meshes"].append({"primitives": [
        {"attributes": {"POSITION": accessor}, "indices": accessor + 1, "material": len(gltf["meshes"])}]})
    gltf["nodes"].append({"mesh": len(gltf["meshes"]) - 1})


def make(triangles):
    rows = max(4, round(math.sqrt(triangles / 4)))
    gltf = {"asset": {"version": "2.0"}, "scene": 0, "bufferViews": [], "accessors": [], "meshes": [], "nodes": [],
            "materials": [
                {"pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.5, 0.3, 1], "metallicFactor": 0.4,
                                          "roughnessFactor": 0.45}},
                {"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.6, 0.6, 1], "metallicFactor": 0,
                                          "roughnessFactor": 0.7}}],
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "aspectRatio": 16 / 9, "znear": 0.1}}]}
    data = bytearray()
    add_mesh(gltf, data, *grid(2 * rows, rows, surface, False))
    side = lambda t: GROUND * (2 * t - 1)
    add_mesh(gltf, data, *grid(4, 4, lambda u, v: (side(u), 0.0, side(v)), False))
    tilt = -0.28  # radians by which the camera looks down
    gltf["nodes"].append({"camera": 0, "translation": [0, 1.8, 4.2],
                          "rotation": [math.sin(tilt / 2), 0, 0, math.cos(tilt / 2)]})
    gltf["scenes"] = [{"nodes": list(range(len(gltf["nodes"])))}]
    gltf["buffers"] = [{"byteLength": len(data)}]
    return gltf, bytes(data)


def glb(gltf, data):
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    size = 12 + 8 + len(text) + 8 + len(data)
    return (struct.pack("<4sII", b"glTF", 2, size) + struct.pack("<I4s", len(text), b"JSON") + text +
            struct.pack("<I4s", len(data), b"BIN\0") + data)


def main():
    if len(sys.argv) != 3 or not sys.argv[2].isdigit():
        sys.exit(__doc__)
    pathlib.Path(sys.argv[1]).write_bytes(glb(*make(int(sys.argv[2]))))


if __name__ == "__main__":
    main()
