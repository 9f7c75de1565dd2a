#!/usr/bin/env python3
"""Draws the figures of docs/motion.md, Modes, A path, Requests, Groups, Gears, Machines and Gantry pairs, anew: motion.py [build folder]

On virtual time: one coarse path by every method of interpolation, one path in every mode of operation, the requests of
examples/moves.txt, those of examples/plotter.txt, of examples/flying_saw.txt, examples/delta.txt and examples/gantry.txt."""
import csv
import math
import subprocess
import sys
import tempfile
from pathlib import Path

BUILD = Path(sys.argv[1] if len(sys.argv) > 1 else "build")
FIGURES = Path(__file__).parent
EXAMPLES = FIGURES.parent.parent / "examples"

METHODS = ("hold", "linear", "cosine", "bspline", "hermite", "natural", "clamped", "quintic")
MODES = ("csp", "csv", "cst")
LINE = EXAMPLES / "methods.toml"


def run(config, output, *arguments):
    subprocess.run([BUILD / "driveline", "run", "--config", config, "--virtual", "--no-plots", "--output", output, *arguments],
                   check=True, capture_output=True)
    with open(output / "axes.csv", encoding="utf-8", newline="") as rows:
        return list(csv.DictReader(rows))


def write_path(file, points):
    file.write_text("time[s],x[rad]\n" + "".join(f"{time:.6g},{at:.9g}\n" for time, at in points), encoding="utf-8")


def column(rows, name):
    return [float(row[name]) for row in rows]


def slope(times, values):
    """Between each row and the one before it."""
    return [0.0] + [(b - a) / (t - s) for (s, t), (a, b) in zip(zip(times, times[1:]), zip(values, values[1:]))]


def write_columns(file, *columns):
    file.write_text("\n".join(",".join(f"{value:.6g}" for value in row) for row in zip(*columns)) + "\n", encoding="utf-8")


def draw(name, height, layout, commands):
    script = (f"set terminal svg size 760,{height} font 'sans,11' background 'white' noenhanced\n"
              f"set output '{FIGURES}/{name}.svg'\nset datafile separator ','\nset grid\nset key above\n"
              f"set multiplot layout {layout}\nset lmargin 9\nset rmargin 2\n{commands}\nunset multiplot\n")
    subprocess.run(["gnuplot"], input=script, check=True, text=True)


def interpolation(folder):
    with open(EXAMPLES / "methods.csv", encoding="utf-8", newline="") as file:
        points = [tuple(map(float, row)) for row in list(csv.reader(file))[1:]]
    start = points[0][1]
    begin_s = None
    for method in METHODS:
        rows = run(LINE, folder / method, "--interpolation", method)
        times, targets = column(rows, "time[s]"), column(rows, "x_target[rad]")
        if begin_s is None:  # "hold" leaps to the first point that is another
            moved = next(time for time, at in zip(times, targets) if at != start)
            begin_s = moved - next(time for time, at in points if at != start)
        times = [time - begin_s for time in times]
        velocities = slope(times, targets)
        write_columns(folder / f"{method}.csv", times, targets, velocities, slope(times, velocities))
    write_columns(folder / "points.csv", *zip(*points))
    dots = f", '{folder}/points.csv' using 1:2 with points pt 7 ps 0.5 lc rgb 'black' notitle"
    commands = "set xrange [0:1]\n"
    for number, (quantity, span) in enumerate((("position, rad", "-0.2:2"), ("velocity, rad/s", "-20:20"),
                                               ("acceleration, rad/s²", "-700:700"))):
        for methods in (METHODS[:4], METHODS[4:]):
            plots = (f"for [m in '{' '.join(methods)}'] '{folder}/'.m.'.csv' every 2 using 1:{number + 2} with lines lw 1.3 "
                     + ("title m" if number == 0 else "notitle"))
            commands += (f"set yrange [{span}]\nset ylabel '{quantity}'\n"
                         f"set xlabel '{'time in s' if number == 2 else ''}'\nplot {plots}{dots if number == 0 else ''}\n")
    draw("interpolation", 720, "3,2", commands)


def modes(folder):
    config = folder / "line.toml"
    config.write_text(LINE.read_text(encoding="utf-8").replace("methods.csv", "path.csv"), encoding="utf-8")
    # 30 rad/s and 280 rad/s² at most.
    write_path(folder / "path.csv", [(i / 1000, 3.2 * (1 - math.cos(3 * math.pi * i / 1000))) for i in range(1334)])
    for mode in MODES:
        rows = run(config, folder / mode, "--mode", mode, "--interpolation", "natural")
        write_columns(folder / f"{mode}.csv", column(rows, "time[s]"), column(rows, "x_target[rad]"),
                      [1000 * error for error in column(rows, "x_following_error[rad]")], column(rows, "x_torque[Nm]"))
    plots = f"for [m in '{' '.join(MODES)}'] '{folder}/'.m.'.csv' using 1:{{0}} with lines title m"
    draw("modes", 600, "3,1",
         "set ylabel 'position, rad'\n" f"plot '{folder}/csp.csv' using 1:2 with lines lc rgb '#606060' title 'path'\n"
         "set ylabel 'following error, mrad'\n" f"plot {plots.format(3)}\n"
         "set xlabel 'time in s'\nset ylabel 'torque, Nm'\n" f"plot {plots.format(4)}")


def requests(folder):
    rows = run(EXAMPLES / "by_hand.toml", folder / "requests", "--script", EXAMPLES / "moves.txt")
    times = column(rows, "time[s]")
    axes = {"turn": "deg", "slide": "mm"}
    places = {name: column(rows, f"{name}_target[{unit}]") for name, unit in axes.items()}
    velocities = {name: slope(times, place) for name, place in places.items()}
    write_columns(folder / "requests.csv", times, *places.values(), *velocities.values())
    file = folder / "requests.csv"
    draw("requests", 480, "2,1",
         "set ylabel 'position'\n"
         f"plot '{file}' using 1:2 with lines title 'turn, deg', '{file}' using 1:3 with lines title 'slide, mm'\n"
         "set xlabel 'time in s'\nset ylabel 'velocity'\n"
         f"plot '{file}' using 1:4 with lines title 'turn, deg/s', '{file}' using 1:5 with lines title 'slide, mm/s'")


def group(folder):
    rows = run(EXAMPLES / "plotter.toml", folder / "group", "--script", EXAMPLES / "plotter.txt")
    times = column(rows, "time[s]")
    x, y = column(rows, "x_target[mm]"), column(rows, "y_target[mm]")
    speeds = [math.hypot(*both) for both in zip(slope(times, x), slope(times, y))]
    write_columns(folder / "group.csv", times, x, y, speeds)
    file = folder / "group.csv"
    draw("group", 640, "2,1",
         "set size ratio -1\nset xrange [-25:425]\nset xlabel 'x, mm'\nset ylabel 'y, mm'\n"
         f"plot '{file}' using 2:3 with lines lw 1.5 title 'path of the axes'\n"
         "set size noratio\nset xrange [*:*]\nset xlabel 'time in s'\nset ylabel 'speed, mm/s'\n"
         f"plot '{file}' using 1:4 with lines lw 1.5 title 'speed along the path'")


def flying_saw(folder):
    rows = run(EXAMPLES / "flying_saw.toml", folder / "saw", "--script", EXAMPLES / "flying_saw.txt")[::4]
    times = column(rows, "time[s]")
    places = {name: column(rows, f"{name}_target[mm]") for name in ("material", "saw", "blade")}
    material, saw = slope(times, places["material"]), slope(times, places["saw"])
    write_columns(folder / "saw.csv", times, *places.values(), material, saw)
    file = folder / "saw.csv"
    draw("flying_saw", 560, "2,1",
         "set ylabel 'position in mm'\n"
         f"plot '{file}' using 1:3 with lines lc 1 title 'saw', '{file}' using 1:4 with lines lc 2 title 'blade'\n"
         "set xlabel 'time in s'\nset ylabel 'velocity in mm/s'\nset yrange [-900:400]\n"
         f"plot '{file}' using 1:6 with lines lc 1 title 'saw', '{file}' using 1:5 with lines lc 3 title 'material'")


def gantry(folder):
    rows = run(EXAMPLES / "gantry.toml", folder / "gantry", "--script", EXAMPLES / "gantry.txt")[::4]
    leader, follower = column(rows, "x1_actual[mm]"), column(rows, "x2_actual[mm]")
    write_columns(folder / "gantry.csv", column(rows, "time[s]"), leader, follower, [b - a for a, b in zip(leader, follower)])
    file = folder / "gantry.csv"
    draw("gantry", 560, "2,1",
         "set ylabel 'actual position in mm'\n"
         f"plot '{file}' using 1:2 with lines lc 1 lw 3 title 'leader x1', '{file}' using 1:3 with lines lc 2 title 'follower x2'\n"
         "set xlabel 'time in s'\nset ylabel 'x2 ahead of x1 in mm'\nset yrange [-0.05:0.6]\n"
         f"set label 'both marks are found: the beam is squared' at 1.25,0.15 offset 14,0\n"
         f"plot '{file}' using 1:4 with lines lc 3 title 'difference: 0.5 mm lie between the marks'")


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def delta_tool(angles):
    """Where the delta of examples/delta.toml has its tool, mm: below the middle of the circle around its knees."""
    knees = []
    for arm, angle in enumerate(angles):
        out, around = 155 + 250 * math.cos(math.radians(angle)), math.radians(120 * arm)
        knees.append((out * math.cos(around), out * math.sin(around), -250 * math.sin(math.radians(angle))))
    a, b = ([p - q for p, q in zip(knee, knees[0])] for knee in knees[1:])
    normal = cross(a, b)
    square = dot(normal, normal)
    middle = [(dot(b, b) * p + dot(a, a) * q) / (2 * square) for p, q in zip(cross(normal, a), cross(b, normal))]
    down = -math.copysign(math.sqrt((600**2 - dot(middle, middle)) / square), normal[2])
    return [p + q + down * r for p, q, r in zip(knees[0], middle, normal)]


def delta(folder):
    rows = run(EXAMPLES / "delta.toml", folder / "delta", "--script", EXAMPLES / "delta.txt")[::2]
    times = column(rows, "time[s]")
    tools = [delta_tool(angles) for angles in zip(*(column(rows, f"a{arm}_demand[deg]") for arm in (1, 2, 3)))]
    speeds = [0.0] + [math.dist(p, q) / (t - s) for (s, t), (p, q) in zip(zip(times, times[1:]), zip(tools, tools[1:]))]
    write_columns(folder / "delta.csv", times, *zip(*tools), speeds)
    file = folder / "delta.csv"
    draw("delta_line", 720, "3,1",
         "set xlabel 'x, mm'\nset ylabel 'z, mm'\nset yrange [-640:-430]\n"
         f"plot '{file}' using 2:4 with lines lw 1.5 title 'path of the tool, from the front'\n"
         "set xlabel ''\nset ylabel 'position, mm'\nset yrange [*:*]\n"
         f"plot '{file}' using 1:2 with lines title 'x', '{file}' using 1:3 with lines title 'y', '{file}' using 1:4 with lines title 'z'\n"
         "set xlabel 'time in s'\nset ylabel 'speed, mm/s'\n"
         f"plot '{file}' using 1:5 with lines lw 1.5 title 'speed of the tool'")


def main():
    for picture in (interpolation, modes, requests, group, flying_saw, delta, gantry):
        with tempfile.TemporaryDirectory() as folder:
            picture(Path(folder))


if __name__ == "__main__":
    main()
