#!/usr/bin/env python3
"""Makes the demo scene: FlightHelmet on a ground plane, seen by a camera.

    make_demo_scene.py FOLDER [--out FOLDER]

FOLDER is the original's, as in the Khronos glTF sample assets (FlightHelmet/glTF): FlightHelmet.gltf, its .bin and
its .png files. The .bin and the images are copied unchanged; flight_helmet.gltf is the original with a ground, in
ground.bin, and a camera added.
"""

import argparse
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


if __name__ == "__main__":
    main()
