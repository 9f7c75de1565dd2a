#!/usr/bin/env python3
"""Writes line8.csv, the path of the eight-axis example line.

    make_line8_path.py            writes line8.csv beside this script
    make_line8_path.py --check    exits 1 unless line8.csv is what it would write

Ten seconds at 1 kHz. All axes begin and end at rest (velocity and acceleration zero). Every axis is put together from
minimum-jerk moves, whose acceleration is continuous, so the cubic spline through the points follows smoothly:

    x, y  circles of 20 rad radius, together: three turns forth, a dwell, three faster turns back
    z     the fastest axis: long and short strokes with hard reversals and dwells
    a, b  oscillations of different frequency and amplitude that swell and fade
    c     one slow excursion with a long dwell
    u     many turns forth, a dwell, many turns back
    v     an indexing table: eight steps forth, four double steps back
"""
import math
import pathlib
import sys

POINTS = 10001
PERIOD_S = 0.001


def blend(t, begin, end):
    """Minimum-jerk transition from 0 to 1 between two times."""
    x = min(max((t - begin) / (end - begin), 0.0), 1.0)
    return x * x * x * (10.0 + x * (6.0 * x - 15.0))


def moves(t, *steps):
    """Sum of moves, each (begin, end, distance)."""
    return sum(distance * blend(t, begin, end) for begin, end, distance in steps)


def circle_angle(t):
    """Three turns in 4.3 s, a dwell of half a second, three turns back in 4 s."""
    return 2.0 * math.pi * moves(t, (0.2, 4.7, 3.0), (5.2, 9.6, -3.0))


def swell(t, begin, end):
    """Rises from 0 to 1 within a second and falls back within a second."""
    return blend(t, begin, begin + 1.0) - blend(t, end - 1.0, end)


def axis_x(t):  # rad
    return 20.0 * (1.0 - math.cos(circle_angle(t)))


def axis_y(t):  # rad
    return 20.0 * math.sin(circle_angle(t))


def axis_z(t):  # rad
    return moves(t, (0.1, 0.7, 62.0), (0.7, 1.3, -62.0), (1.6, 1.85, 22.0), (1.85, 2.1, -22.0), (2.1, 2.35, 22.0),
                 (2.35, 2.6, -22.0), (4.0, 5.0, -100.0), (5.5, 6.5, 100.0), (7.0, 7.6, 62.0), (7.6, 8.2, -62.0))


def axis_a(t):  # deg
    return 720.0 * swell(t, 0.3, 9.7) * math.sin(2.0 * math.pi * 1.5 * (t - 0.3))


def axis_b(t):  # deg
    return 90.0 * swell(t, 1.0, 6.0) * math.sin(2.0 * math.pi * 4.0 * (t - 1.0))


def axis_c(t):  # deg
    return moves(t, (0.5, 3.5, 180.0), (6.5, 9.5, -180.0))


def axis_u(t):  # rev
    return moves(t, (0.2, 4.2, 50.0), (5.0, 9.0, -50.0))


def axis_v(t):  # rev
    forth = [(0.4 + 0.6 * i, 0.7 + 0.6 * i, 0.25) for i in range(8)]
    back = [(5.6 + 1.0 * i, 6.2 + 1.0 * i, -0.5) for i in range(4)]
    return moves(t, *forth, *back)


AXES = [("x[rad]", axis_x, 8), ("y[rad]", axis_y, 8), ("z[rad]", axis_z, 8), ("a[deg]", axis_a, 6),
        ("b[deg]", axis_b, 6), ("c[deg]", axis_c, 6), ("u[rev]", axis_u, 9), ("v[rev]", axis_v, 9)]


def number(value, decimals):
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def make_path():
    rows = ["# Eight axes for ten seconds at 1 kHz, made by make_line8_path.py",
            ",".join(["time[s]"] + [name for name, _, _ in AXES])]
    for i in range(POINTS):
        t = i * PERIOD_S
        rows.append(",".join([number(t, 3)] + [number(f(t), decimals) for _, f, decimals in AXES]))
    return "\n".join(rows) + "\n"


def main():
    file = pathlib.Path(__file__).resolve().parent / "line8.csv"
    if sys.argv[1:] == ["--check"]:
        if file.read_text(encoding="ascii") != make_path():
            sys.exit(f"{file} is not what {sys.argv[0]} writes")
    elif not sys.argv[1:]:
        file.write_text(make_path(), encoding="ascii")
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()
