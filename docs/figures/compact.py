#!/usr/bin/env python3
"""Makes SVG files smaller without changing the picture: compact.py FILE...

Leaves out points of a line that are closer than a fifth of a pixel to the line without them, and rounds the rest to a
tenth of a pixel.
"""
import math
import re
import sys
from pathlib import Path

TOLERANCE = 0.2  # pixels
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
PATH = re.compile(r"(?<= d=')(M[^'a-zK-Z]*(?:[ML][^'a-zA-Z]*)*)(?=')")
POINTS = re.compile(r"""(?<= points=")[^"]*(?=")|(?<= points = ')[^']*(?=')""")


def distance(point, start, end):
    """Of a point from a segment."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length2 = dx * dx + dy * dy
    along = 0.0
    if length2 > 0.0:
        along = min(1.0, max(0.0, ((point[0] - start[0]) * dx + (point[1] - start[1]) * dy) / length2))
    return math.hypot(point[0] - start[0] - along * dx, point[1] - start[1] - along * dy)


def thinned(points):
    """Douglas-Peucker: keeps the ends, and the farthest point of each segment that is beyond the tolerance."""
    kept, todo = {0, len(points) - 1}, [(0, len(points) - 1)]
    while todo:
        first, last = todo.pop()
        if last - first < 2:
            continue
        farthest = max(range(first + 1, last), key=lambda i: distance(points[i], points[first], points[last]))
        if distance(points[farthest], points[first], points[last]) > TOLERANCE:
            kept.add(farthest)
            todo += [(first, farthest), (farthest, last)]
    return [points[i] for i in sorted(kept)]


def line(text):
    numbers = [float(number) for number in NUMBER.findall(text)]
    points = thinned(list(zip(numbers[::2], numbers[1::2])))
    return " ".join(f"{x:.1f},{y:.1f}".replace(".0", "") for x, y in points)


def compact(svg):
    svg = PATH.sub(lambda path: "".join("M" + line(part) for part in path[1].split("M")[1:]), svg)
    svg = POINTS.sub(lambda points: line(points[0]), svg)
    return svg


for name in sys.argv[1:]:
    file = Path(name)
    file.write_text(compact(file.read_text(encoding="utf-8")), encoding="utf-8")
