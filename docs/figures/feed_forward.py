#!/usr/bin/env python3
"""Makes figures and table of docs/motion.md, Feed-forward and dead time, anew: feed_forward.py [build folder]

One MSD with friction and a weight, on virtual time, along a path of 1 kHz: without and with feed-forward and compensation
of the dead time. Then `driveline identify` looks for its load. Draws docs/figures/feed_forward.svg and identify.svg, prints
the table."""
import csv
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

BUILD = Path(sys.argv[1] if len(sys.argv) > 1 else "build")
FIGURES = Path(__file__).parent

SLAVE = """[slave.plant]
inertia_kg_m2 = 6e-4
viscous_friction_nm_s = 2e-3
coulomb_friction_nm = 0.15
[slave.plant.load]
gravity_nm = 0.8
"""
# P 1516 = 0: the drive's own feed-forward of its motor's inertia is off.
NOTHING = "[[slave.sdo]]\nindex = 0x25EC\ntype = \"float\"\nvalue = 0\n"
INERTIA = "inertia = 6e-4\n"
LOAD = INERTIA + "viscous_friction = 2e-3\ncoulomb_friction = 0.15\ngravity = 0.8\n"
KINDS = {"none": (NOTHING, ""), "inertia, by the drive": ("", INERTIA), "inertia, friction, weight": ("", LOAD)}


def describe(folder, cycle_us, sdos, axis, path):
    (folder / "line.toml").write_text(
        f'[line]\ncycle_us = {cycle_us}\n{path}[telemetry]\nenabled = false\n[[slave]]\nname = "x"\n{SLAVE}{sdos}'
        f'[[axis]]\nname = "x"\nmax_velocity = 100\n{axis}', encoding="utf-8")


def drive(folder, *arguments):
    done = subprocess.run([BUILD / "driveline", arguments[0], "--config", folder / "line.toml", "--virtual", "--json",
                           "--no-plots", "--output", folder, *arguments[1:]], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def write_path(folder):
    """From rest to rest, 24 rad/s and 395 rad/s² at most, once the drive has caught the weight, which has no brake."""
    rows = ["time[s],x[rad]"]
    for i in range(1401):
        t = max(i - 400, 0) / 1000
        rows.append(f"{i / 1000},{2.5 * math.sin(math.pi * t) ** 2 * (1 - math.cos(4 * math.pi * t))}")
    (folder / "path.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")


def read_errors(file):
    """Following error and path error in mrad, RMS and largest of each."""
    with open(file, encoding="utf-8", newline="") as rows:
        rows = [row for row in csv.DictReader(rows) if float(row["time[s]"]) >= 0.3]
    path = "x_commanded[rad]" if "x_commanded[rad]" in rows[0] else "x_target[rad]"
    following = [float(row["x_following_error[rad]"]) for row in rows]
    late = [float(row[path]) - float(row["x_actual[rad]"]) for row in rows]
    return [1000 * figure for of in (following, late)
            for figure in (math.sqrt(sum(e * e for e in of) / len(of)), max(map(abs, of)))]


def draw(name, height, commands):
    script = (f"set terminal svg size 760,{height} font 'sans,11' background 'white' noenhanced\n"
              f"set output '{FIGURES}/{name}.svg'\nset datafile separator ','\nset grid\n"
              f"set multiplot layout 2,1\nset lmargin 10\nset rmargin 3\n{commands}\nunset multiplot\n")
    subprocess.run(["gnuplot"], input=script, check=True, text=True)


def main():
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        write_path(folder)
        print("| cycle | feed-forward | dead time | following error, RMS and largest | path error, RMS and largest |")
        print("|---|---|---|---|---|")
        curves = []
        for cycle_us in (1000, 125):
            for dead_time in ("none", "compensated"):
                for kind, (sdos, axis) in KINDS.items():
                    describe(folder, cycle_us, sdos, axis, f'[path]\nfile = "path.csv"\ndead_time = "{dead_time}"\n')
                    drive(folder, "run")
                    errors = read_errors(folder / "axes.csv")
                    print(f"| {cycle_us} µs | {kind} | {dead_time} | {errors[0]:.3f} and {errors[1]:.3f} mrad | "
                          f"{errors[2]:.3f} and {errors[3]:.3f} mrad |")
                    if cycle_us == 1000 and dead_time == "compensated":
                        curves.append((folder / f"{len(curves)}.csv", kind))
                        (folder / "axes.csv").rename(curves[-1][0])
        plots = ", ".join(f"'{file}' skip 1 using 1:($4*1000) with lines lw 1.4 title '{kind}'" for file, kind in curves)
        last = curves[-1][0]
        draw("feed_forward", 520,
             "before=0\nt0=-1\nset xrange [0.3:1.45]\nset key above\nset ylabel 'velocity, rad/s'\nset format x ''\n"
             f"plot '{last}' skip 1 using 1:(d=($3-before)/($1-t0), before=$3, t0=$1, abs(d)<50 ? d : NaN) "
             "with lines lc rgb '#606060' notitle\n"
             "set format x\nset xlabel 'time in s'\nset ylabel 'path error, mrad'\n" f"plot {plots}")
        describe(folder, 1000, "", "", "")
        print(json.dumps(drive(folder, "identify", "x", "--distance", "12")["load"], indent=1))
        draw("identify", 520,
             f"load='{folder}/load.csv'\nset key above\nset format x ''\nset ylabel 'torque, Nm'\n"
             "plot load skip 1 using 1:6 with points pt 7 ps 0.9 lc rgb '#9ecae1' title 'by the figures found', "
             "load skip 1 using 1:5 with points pt 7 ps 0.25 lc rgb '#08306b' title 'measured'\n"
             "set format x\nset xlabel 'time in s'\nset ylabel 'difference, mNm'\n"
             "plot load skip 1 using 1:(1000*($5-$6)) with impulses lc rgb '#dd181f' notitle")


if __name__ == "__main__":
    main()
