#!/usr/bin/env python3
"""Prints a row of the table of triangles and peaks from two reports of sg_relighting.

usage: gaussian_frames.py REPORT.json REPORT_WITHOUT_CONTACT.json

Times are medians over the frames but the first, which also prepares what later ones reuse.
"""
import json
import statistics
import sys


def read(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def stage(report, name):
    return statistics.median(frame["stages"][name] for frame in report["frames"][1:])


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    report, bare = read(sys.argv[1]), read(sys.argv[2])
    frame = report["frames"][-1]
    whole = statistics.median(f["milliseconds"] for f in report["frames"][1:])
    print(f"| {report['preparation']['triangles']} | {frame['peaks']} | {frame['cones']['mean']:.1f} | "
          f"{report['preparation']['seconds']['voxels']:.2f} | {stage(report, 'placement'):.0f} | "
          f"{stage(report, 'visibility'):.0f} | {stage(bare, 'visibility'):.0f} | {whole:.0f} |")


if __name__ == "__main__":
    main()
