#!/usr/bin/env python3
"""Draws docs/figures/homing_*.svg from the CSV of build/bench/homing_paths: homing.py FILE.csv FOLDER."""
import csv
import sys
from collections import defaultdict
from pathlib import Path

# The machine of bench/homing_paths.cpp, in revolutions.
LIMIT, EDGE, CAM = 4.3, 1.4, (0.6, 1.7)
FAST, SLOW = 2.0, 0.4
LEFT, RIGHT = -5.0, 5.0

COLOURS = ("#0072b2", "#d55e00", "#009e73")  # told apart also by the colour-blind (Okabe and Ito)
SWITCH, INDEX, HOME, TEXT = "#f2e2a0", "#b8b8b8", "#444444", "#222222"
WIDTH, PLOT, GAP = 250, 190, 14  # of a panel, in px
LANE, HEAD, FOOT = 13, 32, 20

GROUPS = {
    "limit": ([1, 2, 17, 18], 4),
    "switch": ([3, 4, 5, 6, 19, 20, 21, 22], 4),
    "cam": ([7, 8, 9, 10, 11, 12, 13, 14, 23, 24, 25, 26, 27, 28, 29, 30], 4),
    "index": ([33, 34, 35, 37], 4),
}


def number(method):
    return method - 16 if 16 < method < 31 else method


def switches(method):
    """Name, from and to of the switches that the method looks at."""
    limits = [("−", LEFT, -LIMIT), ("+", LIMIT, RIGHT)]
    n = number(method)
    if n in (1, 2):
        return [limits[n - 1]]
    if n in (3, 4):
        return [("ref", EDGE, RIGHT)]
    if n in (5, 6):
        return [("ref", LEFT, -EDGE)]
    if n <= 14:
        return [("ref", *CAM), limits[1] if n <= 10 else limits[0]]
    return []


def has_index(method):
    return method <= 14 or method in (33, 34)


def read(name):
    paths, homes = defaultdict(lambda: defaultdict(list)), defaultdict(dict)
    with open(name, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            method, start = int(row["method"]), int(row["start"])
            if row["home_rev"]:
                homes[method][start] = float(row["home_rev"])
            else:
                paths[method][start].append(tuple(float(row[key]) for key in ("time_s", "position_rev", "speed_rev_s")))
    return paths, homes


def line(x1, y1, x2, y2, colour, width, extra=""):
    return (f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
            f'stroke-width="{width}" {extra}/>')


def text(x, y, words, size=11, anchor="middle", colour=TEXT, extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" fill="{colour}" {extra}>{words}</text>'


def legs(samples):
    """The path in pieces of one speed: fast, slow or standing."""
    pieces = []
    for time, position, speed in samples:
        kind = "fast" if abs(speed) > 1.25 * SLOW else "slow"
        if not pieces or pieces[-1][0] != kind:
            if pieces:
                pieces[-1][1].append((time, position))
            pieces.append((kind, []))
        pieces[-1][1].append((time, position))
    return pieces


class Panel:
    def __init__(self, method, paths, homes, left, top, longest):
        self.method, self.paths, self.homes = method, paths, homes
        self.left, self.top, self.longest = left, top + HEAD, longest
        self.out = []

    def x(self, position):
        return self.left + (position - LEFT) / (RIGHT - LEFT) * WIDTH

    def y(self, time):
        return self.top + 6 + time / self.longest * (PLOT - 12)

    def background(self):
        lanes = switches(self.method)
        bottom = self.top + PLOT
        self.out.append(text(self.left, self.top - 14, f"{self.method}", 14, "start", extra='font-weight="bold"'))
        for i, (name, begin, end) in enumerate(lanes):
            x, width = self.x(begin), self.x(end) - self.x(begin)
            self.out.append(f'<rect x="{x:.1f}" y="{self.top}" width="{width:.1f}" height="{PLOT}" fill="{SWITCH}" '
                            f'opacity="{0.75 if name == "ref" or len(lanes) == 1 else 0.35}"/>')
            self.lane(name, begin, end, bottom + 4 + i * LANE)
        if has_index(self.method):
            for turn in range(int(LEFT) + 1, int(RIGHT)):
                self.out.append(line(self.x(turn), self.top, self.x(turn), bottom, INDEX, 0.7, 'stroke-dasharray="1.5 2.5"'))
                self.out.append(line(self.x(turn), self.top - 4, self.x(turn), self.top, INDEX, 1.5))
        self.out.append(f'<rect x="{self.left}" y="{self.top}" width="{WIDTH}" height="{PLOT}" fill="none" '
                        'stroke="#888888" stroke-width="0.8"/>')
        for second in range(1, int(self.longest)):
            self.out.append(line(self.left - 4, self.y(second), self.left, self.y(second), "#888888", 0.8))
        self.out.append(text(self.left + WIDTH - 3, bottom - 4, f"{self.longest:.0f} s", 9, "end", "#777777"))

    def lane(self, name, begin, end, top):
        """The level of a switch along the axis."""
        high, low = top + 1, top + LANE - 4
        points = [(LEFT, begin <= LEFT)]
        for edge, level in ((begin, True), (end, False)):
            if LEFT < edge < RIGHT:
                points += [(edge, not level), (edge, level)]
        points.append((RIGHT, end >= RIGHT))
        shape = " ".join(f"{self.x(p):.1f},{high if level else low}" for p, level in points)
        self.out.append(f'<polyline points="{shape}" fill="none" stroke="#8a6d00" stroke-width="1.1"/>')
        self.out.append(text(self.left - 3, low, name, 9, "end", "#8a6d00"))

    def home(self):
        places = sorted({round(home, 2) for home in self.homes.values()})
        for place in places:
            x = self.x(place)
            if len(places) == 1:
                self.out.append(line(x, self.top, x, self.top + PLOT, HOME, 1.1, 'stroke-dasharray="6 3"'))
            y = self.top - 1
            self.out.append(f'<path d="M{x:.1f},{y:.1f} l-4,-7 l8,0 z" fill="{HOME}"/>')

    def path(self, start, samples):
        colour = COLOURS[start]
        for kind, points in legs(samples):
            width = 2.6 if kind == "fast" else 1.2
            shape = " ".join(f"{self.x(p):.1f},{self.y(t):.1f}" for t, p in points[::4] + points[-1:])
            self.out.append(f'<polyline points="{shape}" fill="none" stroke="{colour}" stroke-width="{width}" '
                            'stroke-linejoin="round"/>')
        first, last = samples[0], samples[-1]
        self.out.append(f'<circle cx="{self.x(first[1]):.1f}" cy="{self.y(0):.1f}" r="3.6" fill="white" '
                        f'stroke="{colour}" stroke-width="1.8"/>')
        self.out.append(f'<circle cx="{self.x(last[1]):.1f}" cy="{self.y(last[0]):.1f}" r="3" fill="{colour}"/>')

    def draw(self):
        self.background()
        self.home()
        for start, samples in sorted(self.paths.items()):
            self.path(start, samples)
        return self.out


def legend(x, y):
    out = []
    for i, words in enumerate(("from the left", "from the middle", "from the right")):
        out.append(f'<circle cx="{x}" cy="{y - 4}" r="3.6" fill="white" stroke="{COLOURS[i]}" stroke-width="1.8"/>')
        out.append(text(x + 8, y, words, 11, "start"))
        x += 118
    for width, words in ((2.6, f"{FAST:g} rev/s (6099h:01)"), (1.2, f"{SLOW:g} rev/s (6099h:02)")):
        out += [line(x, y - 4, x + 18, y - 4, "#555555", width), text(x + 23, y, words, 11, "start")]
        x += 148
    out += [f'<rect x="{x}" y="{y - 10}" width="12" height="12" fill="{SWITCH}"/>', text(x + 16, y, "switch active", 11, "start")]
    x += 104
    out += [line(x, y - 10, x, y + 2, INDEX, 1, 'stroke-dasharray="1.5 2.5"'), text(x + 5, y, "index pulse", 11, "start")]
    x += 84
    out += [f'<path d="M{x},{y} l-4,-7 l8,0 z" fill="{HOME}"/>', text(x + 8, y, "home", 11, "start"),
            text(x + 62, y, "time runs downwards, a tick is 1 s", 11, "start", "#777777")]
    return out


def figure(methods, columns, paths, homes):
    height = HEAD + PLOT + FOOT + LANE
    rows = [methods[i:i + columns] for i in range(0, len(methods), columns)]
    out = []
    for i, row in enumerate(rows):
        longest = max(samples[-1][0] for method in row for samples in paths[method].values())
        longest = max(2.0, float(int(longest) + 1))
        for k, method in enumerate(row):
            left = 30 + k * (WIDTH + GAP + 16)
            out += Panel(method, paths[method], homes[method], left, 34 + i * height, longest).draw()
    width = max(790, 40 + columns * (WIDTH + GAP + 16))
    whole = 34 + len(rows) * height
    head = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {whole}" width="{width}" height="{whole}" '
            'font-family="sans-serif"><rect width="100%" height="100%" fill="white"/>')
    return "\n".join([head, *legend(34, 20), *out, "</svg>"]) + "\n"


def main():
    paths, homes = read(sys.argv[1])
    for name, (methods, columns) in GROUPS.items():
        svg = figure(methods, columns, paths, homes)
        (Path(sys.argv[2]) / f"homing_{name}.svg").write_text(svg, encoding="utf-8")


if __name__ == "__main__":
    main()
