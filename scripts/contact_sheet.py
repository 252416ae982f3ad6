#!/usr/bin/env python3
"""Puts several 8-bit RGB PNG files of one size into one, row by row.

    contact_sheet.py OUT.png [--columns N] [--of COUNT] FILE.png...

--of takes that many of the files, evenly spread. Needs nothing but Python.
"""

import argparse
import struct
import zlib


def paeth(a, b, c):
    p = a + b - c
    distances = (abs(p - a), a), (abs(p - b), b), (abs(p - c), c)
    return min(distances, key=lambda d: d[0])[1]


def unfilter(kind, line, above):
    """One line of RGB bytes, the filter of the PNG specification undone."""
    for i, byte in enumerate(line):
        left = line[i - 3] if i >= 3 else 0
        corner = above[i - 3] if i >= 3 else 0
        add = (0, left, above[i], (left + above[i]) // 2, paeth(left, above[i], corner))[kind]
        line[i] = (byte + add) & 255
    return line


def read(path):
    """Width, and lines of RGB bytes."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG"
    at, packed, width = 8, b"", 0
    while at < len(data):
        length, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + length]
        at += 12 + length
        if kind == b"IHDR":
            width, _, depth, colour = struct.unpack_from(">IIBB", body)
            assert (depth, colour) == (8, 2), f"{path} is not 8-bit RGB"
        elif kind == b"IDAT":
            packed += body
    raw, lines, above = zlib.decompress(packed), [], bytearray(3 * width)
    for start in range(0, len(raw), 3 * width + 1):
        above = unfilter(raw[start], bytearray(raw[start + 1 : start + 1 + 3 * width]), above)
        lines.append(bytes(above))
    return width, lines


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def write(path, width, lines):
    raw = b"".join(b"\x00" + line for line in lines)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        file.write(chunk(b"IHDR", struct.pack(">IIBBBBB", width, len(lines), 8, 2, 0, 0, 0)))
        file.write(chunk(b"IDAT", zlib.compress(raw, 9)))
        file.write(chunk(b"IEND", b""))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("files", nargs="+")
    parser.add_argument("--columns", type=int, default=4)
    parser.add_argument("--of", type=int)
    options = parser.parse_args()
    files = options.files
    if options.of and options.of < len(files):
        files = [files[i * len(files) // options.of] for i in range(options.of)]
    images = [read(path) for path in files]
    width, height = images[0][0], len(images[0][1])
    black = bytes(3 * width)
    lines = []
    for first in range(0, len(images), options.columns):
        row = [lines_of for _, lines_of in images[first : first + options.columns]]
        row += [[black] * height] * (options.columns - len(row))
        lines += [b"".join(image[y] for image in row) for y in range(height)]
    write(options.out, width * options.columns, lines)


if __name__ == "__main__":
    main()
