#!/usr/bin/env python3
"""Draws the errors of the glossy table of the benchmarks' report.

    plot_errors.py BENCH.md OUT.svg

A panel for each kind of material: relRMSE over the width of the lobe, a line for each way to shade.
"""
import math
import pathlib
import re
import sys

COLOURS = {"sampled": "#c0392b", "filtered": "#d68910", "refined, σ = 2": "#1f618d", "refined, σ = 1": "#239b56"}
WAYS = list(COLOURS)
WIDTH, HEIGHT, LEFT, TOP = 250, 220, 60, 40
LOW, HIGH = 0.05, 200  # percent


def read_table(text):
    """{kind: [(width of the lobe, [error of each way in percent])]}"""
    panels = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|\n ").split("|")]
        found = re.fullmatch(r"(metal, GGX α|dielectric, GGX α|half Phong) ([0-9.]+)", cells[0])
        if found:
            errors = [float(cells[1 + 3 * i].rstrip("%")) for i in range(len(WAYS))]
            panels.setdefault(found[1], []).append((float(found[2]), errors))
    return panels


def y_of(error):
    return TOP + HEIGHT * math.log(HIGH / max(error, LOW)) / math.log(HIGH / LOW)


def panel(name, points, left):
    widths = [w for w, _ in points]
    low, high = min(widths), max(widths)
    x_of = lambda w: left + WIDTH * math.log(w / low) / math.log(high / low)
    parts = [f'<rect x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#888"/>',
             f'<text x="{left + WIDTH / 2}" y="{TOP + HEIGHT + 36}" text-anchor="middle">{name}</text>']
    for percent in (0.1, 1, 10, 100):
        parts.append(f'<line x1="{left}" x2="{left + WIDTH}" y1="{y_of(percent):.1f}" y2="{y_of(percent):.1f}" '
                     'stroke="#ddd"/>')
        parts.append(f'<text x="{left - 6}" y="{y_of(percent) + 4:.1f}" text-anchor="end">{percent:g}%</text>')
    for w in widths:
        parts.append(f'<text x="{x_of(w):.1f}" y="{TOP + HEIGHT + 16}" text-anchor="middle">{w:g}</text>')
    for i, way in enumerate(WAYS):
        line = " ".join(f"{x_of(w):.1f},{y_of(errors[i]):.1f}" for w, errors in points)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{COLOURS[way]}" stroke-width="2"/>')
    return parts


def main(arguments):
    if len(arguments) != 2:
        sys.exit(__doc__)
    panels = read_table(pathlib.Path(arguments[0]).read_text(encoding="utf-8"))
    if not panels:
        sys.exit(f"{arguments[0]}: has no table of glossy materials; run ./build.sh bench")
    parts = []
    for i, (name, points) in enumerate(panels.items()):
        parts += panel(name, sorted(points), LEFT + i * (WIDTH + LEFT))
    for i, way in enumerate(WAYS):
        x = LEFT + i * 190
        parts.append(f'<line x1="{x}" x2="{x + 24}" y1="18" y2="18" stroke="{COLOURS[way]}" stroke-width="2"/>')
        parts.append(f'<text x="{x + 30}" y="22">{way}</text>')
    width, height = LEFT + len(panels) * (WIDTH + LEFT), TOP + HEIGHT + 50
    svg = (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" '
           f'font-size="11"><rect width="100%" height="100%" fill="white"/>' + "".join(parts) + "</svg>\n")
    pathlib.Path(arguments[1]).write_text(svg, encoding="utf-8")


main(sys.argv[1:])
