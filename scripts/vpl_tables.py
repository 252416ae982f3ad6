#!/usr/bin/env python3
"""Prints the tables of docs/gather.md from the CSV files that scripts/vpls.sh writes.

usage: vpl_tables.py FILE.csv...    (files of several scenes; exponents stand in their names)
"""
import csv
import pathlib
import sys


def read(path):
    parts = path.stem.split("_")
    exponents = f"{parts[-3]}–{parts[-2]}"
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            row["exponents"] = exponents
            row["scene"] = pathlib.Path(row["scene"]).stem
            yield row


def percent(text):
    return f"{100 * float(text):.2f}%"


def gathering(rows):
    print("| Scene, exponents | VPLs that shine | way | nodes or rays: least / mean / most | relRMSE | mre | p95 | bias | × shining | × all |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for r in rows:
        print(f"| {r['scene']}, {r['exponents']} | {r['shining']} | {r['gather']} | "
              f"{r['nodes_min']} / {float(r['nodes_mean']):.0f} / {r['nodes_max']} | {percent(r['rel_rmse'])} | "
              f"{percent(r['mre'])} | {percent(r['p95'])} | {percent(r['bias'])} | "
              f"{float(r['times_brute_shining']):.1f} | {float(r['times_brute_all']):.1f} |")


def pixels(rows):
    print("| Scene | gathered | pixels | share of the covered ones | nodes: least / mean / most | PSNR | relRMSE | mre | µs a covered pixel | × all |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for r in rows:
        chosen = bool(r["pixels"])
        print(f"| {r['scene']} | {r['gather']} | {r['pixels'] or 'all'} | "
              f"{100 * float(r['pixel_share']) if chosen else 100:.1f}% | "
              f"{r['nodes_min']} / {float(r['nodes_mean']):.0f} / {r['nodes_max']} | "
              f"{float(r['psnr_db']):.1f} dB | " .replace("0.0 dB", "") +
              f"{percent(r['rel_rmse'])} | {percent(r['mre'])} | {float(r['microseconds']):.2f} | "
              f"{float(r['times_brute_all']):.0f} |")


def counts(rows):
    print("| Scene | VPLs (shine) | bounces | nodes: least / mean / most | relRMSE | mre | × shining | × all |")
    print("|---|---|---|---|---|---|---|---|")
    for r in rows:
        print(f"| {r['scene']} | {r['vpls']} ({r['shining']}) | {r['bounces']} | "
              f"{r['nodes_min']} / {float(r['nodes_mean']):.0f} / {r['nodes_max']} | {percent(r['rel_rmse'])} | "
              f"{percent(r['mre'])} | {float(r['times_brute_shining']):.1f} | {float(r['times_brute_all']):.1f} |")


def main(paths):
    printers = {"gather": gathering, "ways": gathering, "traced": gathering, "pixels": pixels, "counts": counts}
    for kind, show in printers.items():
        rows = [row for path in paths if path.stem.endswith("_" + kind) for row in read(path)]
        if rows:
            print(f"\n{kind}\n")
            show(rows)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main([pathlib.Path(name) for name in sys.argv[1:]])
