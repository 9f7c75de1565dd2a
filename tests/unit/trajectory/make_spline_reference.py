#!/usr/bin/env python3
"""make_spline_reference.py FILE: writes values of cubic splines in exact rational arithmetic, rounded once at the end.

An independent oracle for the interpolator: the four power coefficients of every segment are unknowns of one dense
system (values at both ends of each segment, continuity of the first and second derivative, two end conditions), which
Gaussian elimination over fractions solves exactly. No moments, no tridiagonal solver, no rounding. B-splines come from
the recursion of Cox and de Boor over polynomials, Hermite curves and quintics from one dense system per segment.
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


def times(a, b):
    """Product of polynomials, coefficients from the constant on."""
    product = [F(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            product[i + j] += x * y
    return product


def plus(a, b):
    longest = max(len(a), len(b))
    return [x + y for x, y in zip(a + [F(0)] * (longest - len(a)), b + [F(0)] * (longest - len(b)))]


def derivative(a):
    return [k * x for k, x in enumerate(a)][1:]


def value(a, t):
    return sum(x * t**k for k, x in enumerate(a))


def basis(knots, i, degree, span):
    """Cox and de Boor: the B-spline of control point i on one span between knots, a polynomial of the time."""
    if degree == 0:
        return [F(1)] if i == span else [F(0)]
    total = [F(0)]
    rise = knots[i + degree] - knots[i]
    fall = knots[i + degree + 1] - knots[i + 1]
    if rise != 0:
        total = plus(total, times([-knots[i] / rise, 1 / rise], basis(knots, i, degree - 1, span)))
    if fall != 0:
        total = plus(total, times([knots[i + degree + 1] / fall, -1 / fall], basis(knots, i + 1, degree - 1, span)))
    return total


def on_lines(t):
    """The straight lines through the points."""
    s = max(k for k in range(len(TIMES) - 1) if TIMES[k] <= t)
    return VALUES[s] + (VALUES[s + 1] - VALUES[s]) * (t - TIMES[s]) / (TIMES[s + 1] - TIMES[s])


def b_spline():
    """Polynomials of the time, one per segment."""
    knots = [TIMES[0]] * 3 + TIMES + [TIMES[-1]] * 3
    control = [on_lines(sum(knots[i + 1:i + 4]) / 3) for i in range(len(TIMES) + 2)]
    control[1] = VALUES[0]  # standstill at both ends
    control[-2] = VALUES[-1]
    segments = []
    for s in range(len(TIMES) - 1):
        curve = [F(0)]
        for i in range(s, s + 4):
            curve = plus(curve, [control[i] * x for x in basis(knots, i, 3, s + 3)])
        segments.append(curve)
    return segments


def through(points):
    """The polynomial through points, as Lagrange has it."""
    total = [F(0)]
    for i, (t, x) in enumerate(points):
        term = [x]
        for j, (other, _) in enumerate(points):
            if j != i:
                term = times(term, [-other / (t - other), 1 / (t - other)])
        total = plus(total, term)
    return total


def osculating(window, derivatives):
    """Polynomials that have at both ends the positions and `derivatives` derivatives, which at an inner point are those
    of the polynomial through `window` points around, and 0 at the ends."""
    last = len(TIMES) - 1
    points = list(zip(TIMES, VALUES))

    def wanted(k):
        first = min(max(k - window // 2, 0), last + 1 - window)
        curve = through(points[first:first + window])
        values = [VALUES[k]]
        for _ in range(derivatives):
            curve = derivative(curve)
            values.append(F(0) if k in (0, last) else value(curve, TIMES[k]))
        return values

    segments = []
    for s in range(last):
        rows = []
        unknowns = 2 * (derivatives + 1)
        for k in (s, s + 1):
            for d, right in enumerate(wanted(k)):
                row = []
                for power in range(unknowns):
                    monomial = [F(0)] * power + [F(1)]
                    for _ in range(d):
                        monomial = derivative(monomial)
                    row.append(value(monomial, TIMES[k]))
                rows.append(row + [right])
        segments.append(solve(rows))
    return segments


def evaluate_segments(segments, t):
    curve = segments[max(s for s in range(len(TIMES) - 1) if TIMES[s] <= t)]
    return [float(value(c, t)) for c in (curve, derivative(curve), derivative(derivative(curve)))]


def make_text():
    lines = ["// Made by make_spline_reference.py: {time, position, velocity, acceleration}."]
    for name, segments in (("kBSplineReference", b_spline()), ("kHermiteReference", osculating(3, 1)),
                           ("kQuinticReference", osculating(5, 2))):
        lines.append(f"constexpr std::array<Reference, {len(SAMPLES)}> {name}{{{{")
        for t in SAMPLES:
            lines.append("    {" + ", ".join(repr(x) for x in [float(t)] + evaluate_segments(segments, t)) + "},")
        lines.append("}};")
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
