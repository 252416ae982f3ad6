#!/usr/bin/env python3
"""Draws what the data-driven tree gains, after Cuts Fig. 8b, and prints it as a table.

    plot_betas.py BETAS.md OUT.svg

BETAS.md is what the program betas prints. Two panels at σ = 2, a bar for each β in every scene: mean pieces of a cut
by threshold, and pieces as a share of those which cuts of the geometric tree take for the same RMS error.
"""
import math
import pathlib
import re
import sys

COLOURS = {1.0: "#909497", 0.5: "#1f618d", 0.0: "#d68910"}
WIDTH, HEIGHT, LEFT, TOP, SIGMA = 380, 220, 60, 40, 2.0


def read_table(text):
    """{(scene, cuts): {β: [(σ, pieces, rms)]}}, σ ascending"""
    curves = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|\n ").split("|")]
        if len(cells) < 6 or not re.fullmatch(r"[0-9.]+", cells[2]):
            continue  # also the tree with the constant of Eq. 12, which is the geometric one
        beta, sigma, pieces, rms = map(float, cells[2:6])
        curves.setdefault((cells[0], cells[1]), {}).setdefault(beta, []).append((sigma, pieces, rms))
    for betas in curves.values():
        for points in betas.values():
            points.sort()
    return curves


def at_sigma(points):
    return next((pieces, rms) for sigma, pieces, rms in points if sigma == SIGMA)


def pieces_at(points, rms):
    """Pieces at an RMS error, interpolated in logarithms; beyond the ends the curve goes on straight."""
    segment = next((i for i in range(len(points) - 2) if rms <= points[i + 1][2]), len(points) - 2)
    (_, pieces_a, rms_a), (_, pieces_b, rms_b) = points[segment:segment + 2]
    t = math.log(rms / rms_a) / math.log(rms_b / rms_a)
    return math.exp((1 - t) * math.log(pieces_a) + t * math.log(pieces_b))


def share_at_equal_rms(betas, beta):
    pieces, rms = at_sigma(betas[beta])
    return pieces / pieces_at(betas[1.0], rms)


def print_gains(curves):
    print("| scene | cuts | β | fewer pieces at σ = 2 | at equal RMS |\n|---|---|---|---|---|")
    for (scene, cuts), betas in sorted(curves.items(), key=lambda item: (item[0][1], item[0][0]), reverse=True):
        for beta in sorted(betas, reverse=True):
            if beta == 1:
                continue
            equal_sigma = 1 - at_sigma(betas[beta])[0] / at_sigma(betas[1.0])[0]
            print(f"| {scene} | {cuts} | {beta:g} | {100 * equal_sigma:.0f}% | "
                  f"{100 * (1 - share_at_equal_rms(betas, beta)):.0f}% |")


def panel(title, scenes, value_of, unit, left):
    """Bars of value_of(betas, β), scenes side by side."""
    highest = max(value_of(betas, beta) for betas in scenes.values() for beta in COLOURS)
    parts = [f'<rect x="{left}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#888"/>',
             f'<text x="{left + WIDTH / 2}" y="{TOP + HEIGHT + 36}" text-anchor="middle">{title}</text>']
    slot = WIDTH / len(scenes)
    for i, (scene, betas) in enumerate(scenes.items()):
        parts.append(f'<text x="{left + (i + 0.5) * slot:.1f}" y="{TOP + HEIGHT + 16}" '
                     f'text-anchor="middle">{scene.removesuffix("_grey")}</text>')
        for j, beta in enumerate(COLOURS):
            height = 0.9 * HEIGHT * value_of(betas, beta) / highest
            x, y, bar = left + (i + 0.14 + 0.24 * j) * slot, TOP + HEIGHT - height, 0.22 * slot
            parts.append(f'<rect x="{x:.1f}" y="{y:.1f}" width="{bar:.1f}" height="{height:.1f}" '
                         f'fill="{COLOURS[beta]}"/>')
            parts.append(f'<text x="{x + bar / 2:.1f}" y="{y - 3:.1f}" text-anchor="middle" font-size="9">'
                         f'{value_of(betas, beta):.0f}{unit}</text>')
    return parts


def draw(curves):
    scenes = {scene: betas for (scene, cuts), betas in curves.items() if cuts == "uniform-threshold"}
    parts = panel("mean pieces of a visibility cut, σ = 2", scenes, lambda betas, beta: at_sigma(betas[beta])[0],
                  "", LEFT)
    parts += panel("pieces at equal RMS, of the geometric tree's", scenes,
                   lambda betas, beta: 100 * share_at_equal_rms(betas, beta), "%", 2 * LEFT + WIDTH)
    for i, (beta, colour) in enumerate(COLOURS.items()):
        x = LEFT + 160 * i
        name = {1.0: "β = 1, geometric", 0.5: "β = 0.5", 0.0: "β = 0, data-driven"}[beta]
        parts.append(f'<rect x="{x}" y="12" width="14" height="12" fill="{colour}"/>')
        parts.append(f'<text x="{x + 20}" y="22">{name}</text>')
    width, height = 3 * LEFT + 2 * WIDTH, TOP + HEIGHT + 50
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" '
            f'font-size="11"><rect width="100%" height="100%" fill="white"/>' + "".join(parts) + "</svg>\n")


def main(arguments):
    if len(arguments) != 2:
        sys.exit(__doc__)
    curves = read_table(pathlib.Path(arguments[0]).read_text(encoding="utf-8"))
    if not curves:
        sys.exit(f"{arguments[0]}: has no table of betas; make one with the program betas")
    print_gains(curves)
    pathlib.Path(arguments[1]).write_text(draw(curves), encoding="utf-8")


main(sys.argv[1:])
