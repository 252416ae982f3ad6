#!/usr/bin/env python3
"""Prints what the frames of an animation cost, from a report of cut_relighting, as Markdown.

    animation_cost.py REPORT.json
"""

import json
import statistics
import sys

ROWS = {
    "milliseconds_lighting": "light up the tree, illumination cut",
    "milliseconds_camera": "camera rays to and past the objects",
    "milliseconds_turn": "cuts into the world's frame",
    "milliseconds_product": "products of shadow fields",
    "milliseconds_shading": "merge and shading",
    "milliseconds": "the whole frame",
}


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        report = json.load(file)
    frames = report["frames"]
    settings = report["settings"]
    print(f"{len(frames)} frames, {settings['width']}x{settings['height']}, {settings['threads'] or 'all'} threads; "
          f"{report['preparation']['receivers']} receivers, {report['preparation']['moving']['samples']} samples of "
          f"shadow fields\n")
    print("| | ms a frame, median | least | most |\n|---|---|---|---|")
    for key, name in ROWS.items():
        values = [frame[key] for frame in frames]
        print(f"| {name} | {statistics.median(values):.0f} | {min(values):.0f} | {max(values):.0f} |")
    if "errors" in frames[0]:
        errors = [100 * frame["errors"]["rel_rmse"] for frame in frames]
        print(f"\nrelRMSE against the posed scene, prepared anew, from all lights: median "
              f"{statistics.median(errors):.2f}%, most {max(errors):.2f}%")


if __name__ == "__main__":
    main()
