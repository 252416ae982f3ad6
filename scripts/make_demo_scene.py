#!/usr/bin/env python3
"""Makes the demo scenes: FlightHelmet on a ground plane, seen by a camera, at rest and with a knot that flies by.

    make_demo_scene.py FOLDER [--out FOLDER]

FOLDER is the original's, as in the Khronos glTF sample assets (FlightHelmet/glTF): FlightHelmet.gltf, its .bin and
its .png files. The .bin and the images are copied unchanged; flight_helmet.gltf is the original with a ground, in
ground.bin, and a camera added. flight_helmet_moving.gltf adds to that a trefoil knot, in knot.bin, and the animation
that moves it around the helmet while it turns.
"""

import argparse
import copy
import json
import math
import pathlib
import shutil
import struct

VERTICAL_FOV = 0.44  # radians
ASPECT = 16 / 9
FILLED = 0.8  # share of the frame's height
AZIMUTH = math.radians(28)  # from +Z, the helmet's front, towards +X
ELEVATION = math.radians(17)  # of the camera above the helmet's middle
GROUND_EXTENT = 60  # half a side, in heights of the helmet

KNOT_RADIUS = 0.25  # of the sphere around it, in heights of the helmet
KNOT_SEGMENTS, KNOT_SIDES = 144, 9  # of the tube, along and around
ORBIT_RADII = (0.62, 0.56)  # along the camera's right and towards the camera, in heights of the helmet
ORBIT_HEIGHT = 0.54  # of its middle above the ground, in heights of the helmet
ORBIT_TILT = 0.16  # how far it sinks towards the camera, in heights of the helmet
ORBIT_START = math.radians(200)  # from the camera's right, away from the camera
DURATION = 4  # seconds, in which the knot goes around once
KEYS_A_SECOND = 24
KNOT_TURNS = 2  # about its own axis; whole, so that the animation repeats
KNOT_AXIS = (0.48, 0.6, 0.64)


def positions(gltf, folder):
    """All vertices, on the original's own terms: no node transforms, one buffer, float triples."""
    assert not any(key in node for node in gltf["nodes"] for key in ("matrix", "translation", "rotation", "scale"))
    data = (folder / gltf["buffers"][0]["uri"]).read_bytes()
    for mesh in gltf["meshes"]:
        for primitive in mesh["primitives"]:
            accessor = gltf["accessors"][primitive["attributes"]["POSITION"]]
            view = gltf["bufferViews"][accessor["bufferView"]]
            start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            stride = view.get("byteStride", 12)
            for i in range(accessor["count"]):
                yield struct.unpack_from("<3f", data, start + i * stride)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def camera_axes():
    """Right, up and backward of the camera, unit vectors."""
    backward = (math.cos(ELEVATION) * math.sin(AZIMUTH), math.sin(ELEVATION), math.cos(ELEVATION) * math.cos(AZIMUTH))
    right = (math.cos(AZIMUTH), 0.0, -math.sin(AZIMUTH))
    up = (
        backward[1] * right[2] - backward[2] * right[1],
        backward[2] * right[0] - backward[0] * right[2],
        backward[0] * right[1] - backward[1] * right[0],
    )
    return right, up, backward


def extent(values):
    values = list(values)
    return min(values), max(values)


def frame(points, middle):
    """Camera position from which the points fill the frame's height by FILLED and are centred in it."""
    right, up, backward = camera_axes()
    seen = [tuple(dot(axis, [p[i] - middle[i] for i in range(3)]) for axis in (right, up, backward)) for p in points]
    tangent = math.tan(VERTICAL_FOV / 2)
    x, y, z = 0.0, 0.0, 1.0
    for _ in range(50):  # a fixed point: each step puts one condition right
        low, high = extent((p[1] - y) / (z - p[2]) for p in seen)
        left, far_right = extent((p[0] - x) / (z - p[2]) for p in seen)
        x += (left + far_right) / 2 * z
        y += (low + high) / 2 * z
        z *= (high - low) / (2 * tangent * FILLED)
    return tuple(middle[i] + right[i] * x + up[i] * y + backward[i] * z for i in range(3))


def add_camera(gltf, points, middle):
    right, up, backward = camera_axes()
    eye = frame(points, middle)
    matrix = [*right, 0, *up, 0, *backward, 0, *eye, 1]
    perspective = {"yfov": VERTICAL_FOV, "aspectRatio": ASPECT, "znear": 0.01, "zfar": 200.0}
    gltf["cameras"] = [{"name": "camera", "type": "perspective", "perspective": perspective}]
    add_node(gltf, {"name": "camera", "camera": 0, "matrix": [round(value, 7) for value in matrix]})


def add_node(gltf, node):
    gltf["scenes"][gltf["scene"]]["nodes"].append(len(gltf["nodes"]))
    gltf["nodes"].append(node)


def add_ground(gltf, middle, height, bottom, out):
    half = GROUND_EXTENT * height
    corners = [(middle[0] + sx * half, bottom, middle[2] + sz * half) for sx, sz in ((-1, 1), (1, 1), (1, -1), (-1, -1))]
    data = b"".join(struct.pack("<3f", *corner) for corner in corners)
    data += struct.pack("<3f", 0, 1, 0) * 4
    data += struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    (out / "ground.bin").write_bytes(data)

    buffer, view, accessor = len(gltf["buffers"]), len(gltf["bufferViews"]), len(gltf["accessors"])
    gltf["buffers"].append({"uri": "ground.bin", "byteLength": len(data)})
    gltf["bufferViews"] += [
        {"buffer": buffer, "byteOffset": 0, "byteLength": 48, "name": "groundPositions"},
        {"buffer": buffer, "byteOffset": 48, "byteLength": 48, "name": "groundNormals"},
        {"buffer": buffer, "byteOffset": 96, "byteLength": 12, "name": "groundIndices"},
    ]
    low, high = (list(struct.unpack("<3f", struct.pack("<3f", *pick))) for pick in (
        (corners[3][0], bottom, corners[3][2]), (corners[1][0], bottom, corners[1][2])))
    gltf["accessors"] += [
        {"bufferView": view, "componentType": 5126, "count": 4, "type": "VEC3", "min": low, "max": high},
        {"bufferView": view + 1, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": view + 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
    ]
    surface = {"baseColorFactor": [0.42, 0.40, 0.38, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9}
    primitive = {
        "attributes": {"POSITION": accessor, "NORMAL": accessor + 1},
        "indices": accessor + 2,
        "material": len(gltf["materials"]),
    }
    gltf["materials"].append({"name": "Ground", "pbrMetallicRoughness": surface})
    add_node(gltf, {"name": "ground", "mesh": len(gltf["meshes"])})
    gltf["meshes"].append({"name": "ground", "primitives": [primitive]})


def normalized(v):
    size = math.sqrt(dot(v, v))
    return tuple(x / size for x in v)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def knot_surface(radius):
    """Positions, normals and triangles of a tube along a trefoil knot about the origin.

    The curve is (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t), which leaves room for a tube of 0.45; 3.45 is the
    radius of the sphere around both.
    """
    tube, reach = 0.45, 3.45
    points, normals, triangles = [], [], []
    for i in range(KNOT_SEGMENTS):
        t = 2 * math.pi * i / KNOT_SEGMENTS
        middle = (math.sin(t) + 2 * math.sin(2 * t), math.cos(t) - 2 * math.cos(2 * t), -math.sin(3 * t))
        along = (math.cos(t) + 4 * math.cos(2 * t), -math.sin(t) + 4 * math.sin(2 * t), -3 * math.cos(3 * t))
        # Away from the axis of the torus that the knot runs around: it comes back to itself after the loop.
        ring = math.hypot(middle[0], middle[1])
        outward = ((ring - 2) * middle[0] / ring, (ring - 2) * middle[1] / ring, middle[2])
        across = normalized(cross(along, outward))
        outward = normalized(cross(across, along))
        for j in range(KNOT_SIDES):
            angle = 2 * math.pi * j / KNOT_SIDES
            normal = tuple(math.cos(angle) * outward[c] + math.sin(angle) * across[c] for c in range(3))
            normals.append(normal)
            points.append(tuple((middle[c] + tube * normal[c]) * radius / reach for c in range(3)))
            next_i, next_j = (i + 1) % KNOT_SEGMENTS, (j + 1) % KNOT_SIDES
            a, b = KNOT_SIDES * i + j, KNOT_SIDES * i + next_j
            c, d = KNOT_SIDES * next_i + next_j, KNOT_SIDES * next_i + j
            triangles += [(a, c, b), (a, d, c)]
    return points, normals, triangles


def flight(middle, height, bottom):
    """Times, positions and rotations of the knot: once around the helmet, lowest in front of it."""
    right, _, backward = camera_axes()
    ahead = normalized((backward[0], 0.0, backward[2]))
    steps = DURATION * KEYS_A_SECOND
    times, places, rotations = [], [], []
    for i in range(steps + 1):
        angle = ORBIT_START - 2 * math.pi * i / steps
        x, z = ORBIT_RADII[0] * math.cos(angle), -ORBIT_RADII[1] * math.sin(angle)
        rise = ORBIT_HEIGHT + ORBIT_TILT * math.sin(angle)
        times.append(i / KEYS_A_SECOND)
        places.append((
            middle[0] + height * (right[0] * x + ahead[0] * z),
            bottom + height * rise,
            middle[2] + height * (right[2] * x + ahead[2] * z),
        ))
        half = math.pi * KNOT_TURNS * i / steps
        rotations.append((*(math.sin(half) * c for c in normalized(KNOT_AXIS)), math.cos(half)))
    return times, places, rotations


COMPONENTS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


class BufferWriter:
    """Collects arrays of one .bin file and the views and accessors upon them."""

    def __init__(self, gltf, prefix):
        self.gltf, self.prefix, self.data = gltf, prefix, b""

    def add(self, name, kind, code, component_type, values, bounds=False):
        data = b"".join(struct.pack(f"<{len(value)}{code}", *value) for value in values)
        view = {"buffer": len(self.gltf["buffers"]), "byteOffset": len(self.data), "byteLength": len(data)}
        count = len(data) // struct.calcsize(code) // COMPONENTS[kind]
        accessor = {"bufferView": len(self.gltf["bufferViews"]), "componentType": component_type, "count": count}
        accessor["type"] = kind
        if bounds:
            columns = list(zip(*struct.iter_unpack(f"<{COMPONENTS[kind]}{code}", data)))  # as stored, rounded to float
            accessor |= {"min": [min(column) for column in columns], "max": [max(column) for column in columns]}
        self.gltf["bufferViews"].append({**view, "name": self.prefix + name})
        self.data += data
        self.gltf["accessors"].append(accessor)
        return len(self.gltf["accessors"]) - 1

    def write(self, file):
        file.write_bytes(self.data)
        self.gltf["buffers"].append({"uri": file.name, "byteLength": len(self.data)})


def add_knot(gltf, middle, height, bottom, out):
    writer = BufferWriter(gltf, "knot")
    points, normals, triangles = knot_surface(KNOT_RADIUS * height)
    attributes = {
        "POSITION": writer.add("Positions", "VEC3", "f", 5126, points, bounds=True),
        "NORMAL": writer.add("Normals", "VEC3", "f", 5126, normals),
    }
    indices = writer.add("Indices", "SCALAR", "H", 5123, triangles)
    times, places, rotations = flight(middle, height, bottom)
    input_accessor = writer.add("Times", "SCALAR", "f", 5126, [(time,) for time in times], bounds=True)
    outputs = {
        "translation": writer.add("Translations", "VEC3", "f", 5126, places),
        "rotation": writer.add("Rotations", "VEC4", "f", 5126, rotations),
    }
    writer.write(out / "knot.bin")

    surface = {"baseColorFactor": [0.55, 0.03, 0.02, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.35}
    primitive = {"attributes": attributes, "indices": indices, "material": len(gltf["materials"])}
    gltf["materials"].append({"name": "Knot", "pbrMetallicRoughness": surface})
    node = len(gltf["nodes"])
    add_node(gltf, {"name": "knot", "mesh": len(gltf["meshes"]), "translation": [round(x, 7) for x in places[0]]})
    gltf["meshes"].append({"name": "knot", "primitives": [primitive]})
    gltf["animations"] = [{
        "name": "flight",
        "samplers": [
            {"input": input_accessor, "interpolation": "LINEAR", "output": output} for output in outputs.values()
        ],
        "channels": [{"sampler": i, "target": {"node": node, "path": path}} for i, path in enumerate(outputs)],
    }]


def main():
    here = pathlib.Path(__file__).resolve().parent
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, help="the original's folder")
    parser.add_argument("--out", type=pathlib.Path, default=here.parent / "assets" / "flight_helmet")
    arguments = parser.parse_args()

    gltf = json.loads((arguments.folder / "FlightHelmet.gltf").read_text())
    arguments.out.mkdir(parents=True, exist_ok=True)
    for name in [item["uri"] for item in gltf["buffers"] + gltf["images"]]:
        shutil.copyfile(arguments.folder / name, arguments.out / name)

    points = list(positions(gltf, arguments.folder))
    bounds = [extent(p[i] for p in points) for i in range(3)]
    middle = [(low + high) / 2 for low, high in bounds]
    bottom, top = bounds[1]
    add_ground(gltf, middle, top - bottom, bottom, arguments.out)
    add_camera(gltf, points, middle)
    (arguments.out / "flight_helmet.gltf").write_text(json.dumps(gltf, indent=1) + "\n")
    moving = copy.deepcopy(gltf)
    add_knot(moving, middle, top - bottom, bottom, arguments.out)
    (arguments.out / "flight_helmet_moving.gltf").write_text(json.dumps(moving, indent=1) + "\n")


if __name__ == "__main__":
    main()
