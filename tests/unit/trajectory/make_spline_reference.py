#!/usr/bin/env python3
"""make_spline_reference.py FILE: writes values of cubic splines in exact rational arithmetic, rounded once at the end.

An independent oracle for the interpolator: the four power coefficients of every segment are unknowns of one dense
system (values at both ends of each segment, continuity of the first and second derivative, two end conditions), which
Gaussian elimination over fractions solves exactly. No moments, no tridiagonal solver, no rounding.
"""
import pathlib
import sys
from fractions import Fraction as F

TIMES = [F(0), F(1, 2), F(3, 4), F(2), F(9, 4), F(4), F(4) + F(1, 1024)]
VALUES = [F(1), F(-2), F(5, 4), F(1, 2), F(8), F(-3), F(-3) + F(1, 512)]
CLAMPS = (F(3, 2), F(-1, 4))
SAMPLES = [F(1, 4), F(1, 2), F(5, 8), F(1), F(15, 8), F(17, 8), F(3), F(511, 128), F(4) + F(1, 2048)]


def powers(t, derivative):
    """Derivative of (1, t, t^2, t^3)."""
    return [[F(1), t, t**2, t**3], [F(0), F(1), 2 * t, 3 * t**2], [F(0), F(0), F(2), 6 * t]][derivative]


def solve(rows):
    """Gauss-Jordan elimination of rows [coefficients..., right side]."""
    for k in range(len(rows)):
        pivot = next(r for r in range(k, len(rows)) if rows[r][k] != 0)
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [value / rows[k][k] for value in rows[k]]
        for r in range(len(rows)):
            if r != k and rows[r][k] != 0:
                factor = rows[r][k]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[k])]
    return [row[-1] for row in rows]


def spline(derivative_at_ends, values_at_ends):
    segments = len(TIMES) - 1
    rows = []

    def add(terms, right):
        row = [F(0)] * (4 * segments + 1)
        for segment, sign, coefficients in terms:
            for i, c in enumerate(coefficients):
                row[4 * segment + i] += sign * c
        row[-1] = right
        rows.append(row)

    for s in range(segments):
        add([(s, 1, powers(F(0), 0))], VALUES[s])
        add([(s, 1, powers(TIMES[s + 1] - TIMES[s], 0))], VALUES[s + 1])
    for s in range(segments - 1):
        for d in (1, 2):
            add([(s, 1, powers(TIMES[s + 1] - TIMES[s], d)), (s + 1, -1, powers(F(0), d))], F(0))
    add([(0, 1, powers(F(0), derivative_at_ends))], values_at_ends[0])
    add([(segments - 1, 1, powers(TIMES[-1] - TIMES[-2], derivative_at_ends))], values_at_ends[1])
    return solve(rows)


def evaluate(solution, t):
    segment = max(s for s in range(len(TIMES) - 1) if TIMES[s] <= t)
    own = solution[4 * segment:4 * segment + 4]
    return [float(sum(a * b for a, b in zip(own, powers(t - TIMES[segment], d)))) for d in range(3)]


def make_text():
    lines = ["// Made by make_spline_reference.py: {time, position, velocity, acceleration}."]
    for name, solution in (("kNaturalReference", spline(2, (F(0), F(0)))), ("kClampedReference", spline(1, CLAMPS))):
        lines.append(f"constexpr std::array<Reference, {len(SAMPLES)}> {name}{{{{")
        for t in SAMPLES:
            lines.append("    {" + ", ".join(repr(value) for value in [float(t)] + evaluate(solution, t)) + "},")
        lines.append("}};")
    return "\n".join(lines) + "\n"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    file = pathlib.Path(sys.argv[1])
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(make_text(), encoding="ascii")


if __name__ == "__main__":
    main()
