#!/usr/bin/env python3
"""Makes a scene of two rooms that a door joins, with furniture and coloured walls, seen by a camera in one of them.

    make_room_scene.py OUT.glb

Nothing in it shines: a program brings the light. Metres.
"""

import array
import math
import pathlib
import sys

from make_ball_scene import add_mesh, glb, grid

LOW, HIGH = (-3.5, 0.0, -2.2), (3.5, 2.8, 2.2)  # inner corners of both rooms together
DIVIDER = (1.1, 1.2)  # of the wall between them along x
DOOR = (-1.3, -0.4, 2.1)  # from z to z, and its height
MATERIALS = {  # base colour
    "plaster": (0.75, 0.73, 0.7), "wood": (0.55, 0.33, 0.17), "red": (0.7, 0.15, 0.1), "blue": (0.15, 0.25, 0.65),
    "floor": (0.45, 0.4, 0.36), "green": (0.2, 0.5, 0.2), "white": (0.85, 0.85, 0.85)}


def corners(low, high):
    return [(high[0] if k & 1 else low[0], high[1] if k & 2 else low[1], high[2] if k & 4 else low[2])
            for k in range(8)]


FACES = {"-x": (0, 4, 6, 2), "+x": (1, 3, 7, 5), "-y": (0, 1, 5, 4), "+y": (2, 6, 7, 3), "-z": (0, 2, 3, 1),
         "+z": (4, 5, 7, 6)}  # counter-clockwise from outside


def box(low, high, faces=tuple(FACES), inside=False):
    """Positions and triangles of faces of a box, each with corners of its own."""
    positions, triangles = array.array("f"), array.array("I")
    points = corners(low, high)
    for face in faces:
        first = len(positions) // 3
        ring = FACES[face][::-1] if inside else FACES[face]
        for k in ring:
            positions.extend(points[k])
        triangles.extend(first + k for k in (0, 1, 2, 0, 2, 3))
    return positions, triangles


def ball(centre, radius, columns=48):
    def point(u, v):
        theta, phi = math.pi * v, 2 * math.pi * u
        return (centre[0] + radius * math.sin(theta) * math.cos(phi), centre[1] + radius * math.cos(theta),
                centre[2] + radius * math.sin(theta) * math.sin(phi))
    return grid(columns, columns // 2, point, False)


def table(x, z, half_x, half_z, height):
    yield box((x - half_x, height - 0.04, z - half_z), (x + half_x, height, z + half_z))
    for sx in (-1, 1):
        for sz in (-1, 1):
            cx, cz = x + sx * (half_x - 0.05), z + sz * (half_z - 0.05)
            yield box((cx - 0.03, 0, cz - 0.03), (cx + 0.03, height - 0.04, cz + 0.03))


def parts():
    """(material, (positions, triangles)) of everything."""
    yield "floor", box(LOW, HIGH, ("-y",), inside=True)
    yield "plaster", box(LOW, HIGH, ("+y", "-z", "+z"), inside=True)
    yield "red", box(LOW, HIGH, ("-x",), inside=True)
    yield "blue", box(LOW, HIGH, ("+x",), inside=True)
    for low, high in (((DIVIDER[0], 0, LOW[2]), (DIVIDER[1], HIGH[1], DOOR[0])),
                      ((DIVIDER[0], 0, DOOR[1]), (DIVIDER[1], HIGH[1], HIGH[2])),
                      ((DIVIDER[0], DOOR[2], DOOR[0]), (DIVIDER[1], HIGH[1], DOOR[1]))):
        yield "plaster", box(low, high)
    for part in table(-1.2, 0.3, 0.8, 0.45, 0.75):
        yield "wood", part
    yield "green", ball((-1.5, 0.95, 0.25), 0.2)
    yield "white", box((-0.95, 0.75, 0.2), (-0.65, 1.05, 0.5))
    yield "wood", box((-2.3, 0, -2.2), (-1.1, 1.9, -1.8))
    yield "white", box((0.35, 0, 1.3), (0.6, 2.8, 1.55))
    yield "red", ball((2.4, 0.5, -0.8), 0.5)
    yield "wood", box((1.9, 0, 1.2), (3.3, 0.5, 2.0))


def looking(eye, target):
    """Rotation of a camera, as a quaternion: first up or down, then around +Y."""
    x, y, z = (t - e for e, t in zip(eye, target))
    around, up = math.atan2(-x, -z), math.atan2(y, math.hypot(x, z))
    ca, sa, cu, su = math.cos(around / 2), math.sin(around / 2), math.cos(up / 2), math.sin(up / 2)
    return [ca * su, sa * cu, -sa * su, ca * cu]


def make():
    names = list(MATERIALS)
    gltf = {"asset": {"version": "2.0"}, "scene": 0, "bufferViews": [], "accessors": [], "meshes": [], "nodes": [],
            "materials": [{"name": name, "pbrMetallicRoughness": {
                "baseColorFactor": [*MATERIALS[name], 1], "metallicFactor": 0, "roughnessFactor": 0.9}}
                          for name in names],
            "cameras": [{"type": "perspective", "perspective": {"yfov": 1.05, "aspectRatio": 16 / 9, "znear": 0.05}}]}
    data = bytearray()
    for material, (positions, triangles) in parts():
        add_mesh(gltf, data, positions, triangles)
        gltf["meshes"][-1]["primitives"][0]["material"] = names.index(material)
    eye = (-3.3, 1.7, 2.0)
    gltf["nodes"].append({"camera": 0, "translation": eye, "rotation": looking(eye, (0.2, 0.9, -0.9))})
    gltf["scenes"] = [{"nodes": list(range(len(gltf["nodes"])))}]
    gltf["buffers"] = [{"byteLength": len(data)}]
    return gltf, bytes(data)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    pathlib.Path(sys.argv[1]).write_bytes(glb(*make()))


if __name__ == "__main__":
    main()
