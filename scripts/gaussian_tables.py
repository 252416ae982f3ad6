#!/usr/bin/env python3
"""Prints the table of docs/sg.md from the CSV files that scripts/gaussians.sh writes.

usage: gaussian_tables.py FILE.csv...    (one a map: SCENE_MAP.csv)
"""
import csv
import pathlib
import sys


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    maps, cells, settings, materials = [], {}, [], []
    for path in map(pathlib.Path, sys.argv[1:]):
        name = path.stem.split("_")[-1]
        maps.append(name)
        with path.open(newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                cells[row["setting"], row["material"], name] = row
                settings += [row["setting"]] * (row["setting"] not in settings)
                materials += [row["material"]] * (row["material"] not in materials)
    print("| Setting | cones a point | " + " | ".join(materials) + " |")
    print("|---" * (2 + len(materials)) + "|")
    for setting in settings:
        rows = [[cells[setting, material, name] for name in maps] for material in materials]
        cones = " / ".join(f"{float(r['cones']):.0f}" for r in rows[0])
        errors = [" / ".join(f"{100 * float(r['rel_rmse']):.1f}" for r in line) for line in rows]
        print(f"| {setting} | {cones} | " + " | ".join(errors) + " |")


if __name__ == "__main__":
    main()
