#!/usr/bin/env python3
"""How many pieces each kind of visibility cut needs for the error that the paper's cuts have.

    nodes_at_equal_error.py [--sigma S] SWEEP.csv...

Reads what trade --visibility-only wrote and prints a Markdown table with a row for each scene and lighting: the
error of visibility alone at uniform-threshold and sigma S (default 2), its pieces, and the pieces of the other kinds
at that error, between the measured points on logarithmic axes. "-" where the sweep does not enclose the error.
"""
import argparse
import collections
import csv
import math
import pathlib
import sys

BASELINE = "uniform-threshold"
OTHERS = ["uniform-optimal", "cosine-threshold", "cosine-optimal"]


def read_curves(paths):
    """{(scene, environment, degrees): {kind: {sigma: (error, pieces)}}}; points without an error are left out."""
    curves = collections.defaultdict(lambda: collections.defaultdict(dict))
    for path in paths:
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                try:
                    error, pieces = float(row["rel_rmse_visibility"] or "nan"), float(row["visibility_pieces"])
                    lighting = row["scene"], row["environment"], row["rotate_env"]
                    kind, sigma = row["cuts"], float(row["sigma"])
                except (KeyError, TypeError, ValueError) as problem:
                    sys.exit(f"{path}: not a file that trade wrote ({problem}); run trade --visibility-only")
                if 0 < error < math.inf:
                    curves[lighting][kind][sigma] = error, pieces
    return curves


def pieces_at(error, points):
    """Pieces at an error on the line through (error, pieces) in log-log; None outside of the points."""
    points = sorted(points)
    for (e0, n0), (e1, n1) in zip(points, points[1:]):
        if e0 <= error <= e1:
            share = math.log(error / e0) / math.log(e1 / e0) if e1 > e0 else 0
            return n0 * (n1 / n0) ** share
    return None


def with_ratio(pieces, baseline):
    return f"{pieces:.1f} ({baseline / pieces:.2f} ×)" if pieces else "-"


def name_of(lighting):
    scene, environment, degrees = lighting
    return f"{pathlib.Path(scene).stem}, {pathlib.Path(environment).stem}, {float(degrees):g}°"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sigma", type=float, default=2)
    parser.add_argument("files", nargs="+", type=pathlib.Path, metavar="SWEEP.csv")
    arguments = parser.parse_args()

    print("| Scene, environment, turn | error | " + " | ".join([BASELINE, *OTHERS]) + " |")
    print("|---" * (3 + len(OTHERS)) + "|")
    ratios = {kind: [] for kind in OTHERS}
    for lighting, kinds in read_curves(arguments.files).items():
        if arguments.sigma not in kinds[BASELINE]:
            sys.exit(f"{name_of(lighting)}: no {BASELINE} at sigma {arguments.sigma:g} with an error of visibility; "
                     "run trade --visibility-only with that point")
        error, baseline = kinds[BASELINE][arguments.sigma]
        found = {kind: pieces_at(error, kinds[kind].values()) for kind in OTHERS}
        for kind, pieces in found.items():
            if pieces:
                ratios[kind].append(baseline / pieces)
        cells = [name_of(lighting), f"{100 * error:.3f}%", f"{baseline:.1f}"]
        print("| " + " | ".join(cells + [with_ratio(found[kind], baseline) for kind in OTHERS]) + " |")
    means = [f"{math.exp(sum(map(math.log, r)) / len(r)):.2f} × ({len(r)})" if r else "-" for r in ratios.values()]
    print("| geometric mean of the ratios (lightings) | | 1 | " + " | ".join(means) + " |")


main()
