"""`driveline plan`: its setpoints judged from outside, and its sentences about files that are wrong."""
import csv
import math
import os
import pathlib
import unittest
import xml.etree.ElementTree

from program import EXAMPLES, ProgramTest

CYCLE_S = 125e-6
CONTOUR = EXAMPLES / "contour.jsonl"
DELTA = EXAMPLES / "delta.jsonl"
LIMITS = {"velocity": 1000.0, "acceleration": 10000.0, "jerk": 1000000.0}  # of both axes of the example, mm
AXES = '{"axes": [{"name": "x", "unit": "mm", "max_velocity": 1000, "max_acceleration": 10000, "max_jerk": 1000000}, ' \
       '{"name": "y", "unit": "mm", "max_velocity": 1000, "max_acceleration": 10000, "max_jerk": 1000000}]}\n'


def differences(values):
    return [(after - before) / CYCLE_S for before, after in zip(values, values[1:])]


def circle_through(a, b, c):
    """Centre and radius."""
    d = 2.0 * (a[0] * (b[1] - c[1]) + b[0] * (c[1] - a[1]) + c[0] * (a[1] - b[1]))
    squares = [x * x + y * y for x, y in (a, b, c)]
    x = (squares[0] * (b[1] - c[1]) + squares[1] * (c[1] - a[1]) + squares[2] * (a[1] - b[1])) / d
    y = (squares[0] * (c[0] - b[0]) + squares[1] * (a[0] - c[0]) + squares[2] * (b[0] - a[0])) / d
    return (x, y), math.dist((x, y), a)


def on_circle(circle, angle):
    (x, y), radius = circle
    return x + radius * math.cos(angle), y + radius * math.sin(angle)


def from_line(a, b):
    """The distance of a place from it."""
    way = (b[0] - a[0], b[1] - a[1])
    def distance(place):
        share = ((place[0] - a[0]) * way[0] + (place[1] - a[1]) * way[1]) / (way[0] ** 2 + way[1] ** 2)
        share = min(1.0, max(0.0, share))
        return math.dist(place, (a[0] + share * way[0], a[1] + share * way[1]))
    return distance


# The contour of the example up to its spline. The arcs are judged as circles: their rest is far from the way.
VIA = circle_through((150.0, 200.0), (80.0, 170.0), (50.0, 100.0))
SHAPES = [from_line((0.0, 0.0), (300.0, 0.0)), lambda place: abs(math.dist(place, (300.0, 100.0)) - 100.0),
          from_line((300.0, 200.0), (150.0, 200.0)), lambda place: abs(math.dist(place, VIA[0]) - VIA[1]),
          from_line((50.0, 100.0), (0.0, 0.0))]


class Plan(ProgramTest):
    def plan(self, file, *arguments):
        """Document and samples of a file of moves."""
        samples = self.directory / "samples.csv"
        result = self.run_program("plan", file, "--json", "--samples", samples, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(samples, encoding="utf-8", newline="") as stream:
            rows = list(csv.DictReader(stream))
        columns = {name: [float(row[name]) for row in rows] for name in rows[0]}
        self.assertEqual(self.files(), sorted({"samples.csv", *(str(name) for name in self.made)}))
        return self.one_document(result.stdout), columns

    def setUp(self):
        super().setUp()
        self.made = []

    def test_setpoints_keep_the_limits_and_the_way(self):
        document, columns = self.plan(CONTOUR)
        self.assertEqual(list(columns), ["time[s]", "x[mm]", "y[mm]", "speed[mm/s]", "line"])
        count = len(columns["time[s]"])
        self.assertAlmostEqual(document["duration_s"], count * CYCLE_S, places=9)
        for k, time in enumerate(columns["time[s]"]):
            self.assertAlmostEqual(time, (k + 1) * CYCLE_S, places=9)
        largest = dict.fromkeys(LIMITS, 0.0)
        for number, axis in enumerate(("x", "y")):
            values = columns[f"{axis}[mm]"]
            for name, limit in LIMITS.items():
                values = differences(values)
                most = max(map(abs, values))
                # 0.3 %: the rounding of places to 2^-40 m, and that of the differences of the mm in the file.
                self.assertLessEqual(most, 1.003 * limit + 100.0 * (name == "jerk"), f"{name} of {axis}")
                told = document["axes"][number][name]
                self.assertAlmostEqual(told["limit"], limit / 1000.0)
                self.assertAlmostEqual(1000.0 * told["largest"] / most, 1.0, places=3)
                largest[name] = max(largest[name], most)
        self.assertGreater(largest["acceleration"], 0.9 * LIMITS["acceleration"], "the axes hardly moved")
        self.assertGreater(largest["jerk"], 0.9 * LIMITS["jerk"])
        places = list(zip(columns["x[mm]"], columns["y[mm]"]))
        self.check_way(places, columns["line"])
        self.assertLess(math.dist(places[0], (0.0, 0.0)), LIMITS["jerk"] * CYCLE_S**3)  # of a single cycle
        self.assertAlmostEqual(math.dist(places[-1], (200.0, 0.0)), 0.0, places=6)
        self.assertEqual(columns["speed[mm/s]"][-1], 0.0)
        # The feed is 500 mm/s, and 200 mm/s along the spline.
        self.assertLessEqual(max(columns["speed[mm/s]"]), 500.001)
        spline = [speed for speed, line in zip(columns["speed[mm/s]"], columns["line"]) if line == 7]
        self.assertLessEqual(max(spline), 200.001)

    def check_way(self, places, lines):
        """Every line of the file is passed in its order, all of the way is within the tolerance of the corners, 0.5 mm, of the
        lines and arcs of the file, and every one of these has been passed at its middle."""
        self.assertEqual(sorted(set(lines)), [2.0, 3.0, 4.0, 5.0, 6.0, 7.0])
        self.assertEqual(lines, sorted(lines), "moves follow one another")
        contour = [place for place, line in zip(places, lines) if line <= 6]
        for place in contour:
            self.assertLessEqual(min(distance(place) for distance in SHAPES), 0.501, place)
        for middle in [(150.0, 0.0), (400.0, 100.0), (225.0, 200.0), on_circle(VIA, 2.36), (25.0, 50.0)]:
            self.assertLess(min(math.dist(place, middle) for place in contour), 0.51, middle)
        # Through the points of the spline, and to those of the lines behind which the axes stop.
        for point in [(0.0, 0.0), (50.0, 20.0), (100.0, -20.0), (150.0, 20.0)]:
            self.assertLess(min(math.dist(place, point) for place, line in zip(places, lines) if line >= 6), 0.05)

    def test_a_delta_keeps_its_joints_and_its_rods(self):
        """The joints by their limits, and the tool by the lengths of the rods: no formula of kinematics but these."""
        document, columns = self.plan(DELTA)
        joints = [f"a{k}[deg]" for k in (1, 2, 3)]
        self.assertEqual(list(columns), ["time[s]", *joints, "x[mm]", "y[mm]", "z[mm]", "speed[mm/s]", "line", "vacuum", "blow"])
        limits = {"velocity": 900.0, "acceleration": 25000.0, "jerk": 2500000.0}
        largest = dict.fromkeys(limits, 0.0)
        for joint in joints:
            values = columns[joint]
            self.assertLessEqual(max(values), 95.0)
            self.assertGreaterEqual(min(values), -30.0)
            for name, limit in limits.items():
                values = differences(values)
                largest[name] = max(largest[name], max(map(abs, values)) / limit)
                self.assertLessEqual(max(map(abs, values)), 1.003 * limit + 500.0 * (name == "jerk"), f"{name} of {joint}")
        self.assertGreater(min(largest.values()), 0.7, largest)
        # The tool is what keeps the joints below their limits: 100 m/s^2 as a vector.
        self.assertAlmostEqual(document["tool"]["acceleration"]["largest"], 100.0, delta=0.3)
        tools = list(zip(columns["x[mm]"], columns["y[mm]"], columns["z[mm]"]))
        for k, tool in enumerate(tools):
            for turn, joint in enumerate(joints):
                angle, around = math.radians(columns[joint][k]), math.radians(120.0 * turn)
                out, up = 200.0 - 45.0 + 250.0 * math.cos(angle), -250.0 * math.sin(angle)
                knee = (out * math.cos(around), out * math.sin(around), up)
                self.assertAlmostEqual(math.dist(knee, tool), 600.0, places=6)
        self.assertLess(math.dist(tools[-1], (0.0, 0.0, -560.0)), 1e-6)
        self.check_suction(document, columns, tools)

    def check_suction(self, document, columns, tools):
        """It picks and places twice: on before it stands at the pick, off when it has arrived where it places."""
        told = [(output["name"], output["value"], output["line"]) for output in document["outputs"]]
        once = [("vacuum", 1, 3), ("vacuum", 0, 6), ("blow", 1, 6), ("blow", 0, 7)]
        self.assertEqual([each[:2] for each in told], [each[:2] for each in once] * 2)
        self.assertEqual([each[2] for each in told], [3, 6, 6, 7, 9, 12, 12, 13])
        for x, y, seconds, vacuum in ((-150.0, 0.0, 0.03, 1.0), (150.0, 0.0, 0.02, 0.0), (-100.0, 60.0, 0.03, 1.0), (150.0, -60.0, 0.02, 0.0)):
            there = [k for k, tool in enumerate(tools) if math.dist(tool, (x, y, -620.0)) < 1e-5]
            self.assertAlmostEqual(len(there) * CYCLE_S, seconds, delta=0.003)
            self.assertEqual(columns["vacuum"][there[-1]], vacuum)
        self.assertAlmostEqual(document["dwell_s"], 0.1, delta=0.002)
        # 10 mm before the pick, to a cycle.
        first = columns["vacuum"].index(1.0)
        self.assertLessEqual(tools[first][2], -610.0 + 1e-9)
        self.assertGreater(tools[first - 1][2], -610.0)

    def test_places_that_a_machine_cannot_have_are_refused(self):
        first, *moves = DELTA.read_text(encoding="utf-8").splitlines(keepends=True)
        for line, part in (('{"line": [0, 0, -900]}', "the machine cannot reach"),
                           ('{"line": [600, 0, -620]}', "the machine cannot reach"),
                           ('{"line": [0, 0, -342]}', "axis a1 would be at"),
                           ('{"line": [0, 0, -560], "dwell": -1}', "the dwell is -1 s"),
                           ('{"line": [0, 0, -570], "outputs": [{"name": "suck", "value": 1}]}', "no output")):
            with self.subTest(line):
                file = self.write("moves.jsonl", first + moves[0] + line + "\n")
                result = self.run_program("plan", file, "--samples", "samples.csv")
                self.check_refused(result, 2, part, "moves.jsonl:3")
                self.assertEqual(self.files(), ["moves.jsonl"], "nothing is left behind")

    def test_half_the_feed_takes_longer_on_the_same_way(self):
        whole, _ = self.plan(CONTOUR)
        half, columns = self.plan(CONTOUR, "--override", "50")
        self.assertGreater(half["duration_s"], 1.5 * whole["duration_s"])
        self.assertAlmostEqual(half["length"], whole["length"], places=9)
        self.assertLessEqual(max(columns["speed[mm/s]"]), 250.001)
        self.check_way(list(zip(columns["x[mm]"], columns["y[mm]"])), columns["line"])

    def test_the_picture_shows_way_and_speed(self):
        self.made = ["contour.svg"]
        self.plan(CONTOUR, "--picture", self.directory / "contour.svg")
        svg = xml.etree.ElementTree.fromstring(self.text("contour.svg"))
        curves = [element.get("points").split() for element in svg.iter() if element.tag.endswith("polyline")]
        self.assertEqual(len(curves), 2)
        for points in curves:
            self.assertGreater(len(points), 100)
            for point in points:
                x, y = map(float, point.split(","))
                self.assertTrue(0.0 <= x <= 800.0 and 0.0 <= y <= 760.0, point)
        self.check_axes(svg, curves[0])

    def check_axes(self, svg, path):
        """Both charts have names, units and ticks, and the ticks agree with the curve."""
        texts = [(element.text, float(element.get("x")), float(element.get("y"))) for element in svg.iter() if element.tag.endswith("text")]
        words = [text for text, _, _ in texts]
        for label in ("x in mm", "y in mm", "speed along the path in mm/s", "time in s"):
            self.assertEqual(words.count(label), 1, label)
        below = {float(text): x for text, x, y in texts if text.lstrip("-").isdigit() and 470.0 < y < 490.0}
        self.assertGreaterEqual(len(below), 5)
        # The contour is from x = 0 mm to x = 400 mm.
        across = [float(point.split(",")[0]) for point in path]
        self.assertAlmostEqual(min(across), below[0.0], delta=1.0)
        self.assertAlmostEqual(max(across), below[400.0], delta=1.0)

    def test_what_cannot_be_planned_is_refused_with_file_and_line(self):
        cases = {
            '{"line": [1e400, 0]}\n': ":2",
            '{"line": [10, 0], "feed": 0}\n': ":2",
            '{"line": [10, 0], "tolerance": -1}\n': ":2",
            '{"line": [10]}\n': ":2",
            '{"lime": [10, 0]}\n': "a move is one of line",
            '{"line": [10, 0]}\n{"arc": [15, 5], "center": [10, 5]}\n{"arc": [90, 0], "center": [10, 5]}\n': ":4",
            '{"arc": [20, 0], "via": [10, 0]}\n': ":2",
            '{"line": [10, 0]\n': ":2",
            "": "plan",
        }
        for text, part in cases.items():
            with self.subTest(text):
                file = self.write("moves.jsonl", AXES + text)
                result = self.run_program("plan", file, "--samples", "samples.csv", "--picture", "way.svg")
                self.check_refused(result, 2, part, "moves.jsonl")
                self.assertEqual(self.files(), ["moves.jsonl"], "nothing is left behind")

    def test_a_folder_that_is_not_there_and_a_full_disk(self):
        result = self.run_program("plan", CONTOUR, "--samples", "nowhere/samples.csv")
        self.check_refused(result, 1, "nowhere/samples.csv", "No such file")
        os.symlink("/dev/full", self.directory / "samples.csv")
        result = self.run_program("plan", CONTOUR, "--samples", "samples.csv")
        self.check_refused(result, 1, "samples.csv", "No space left")
        self.assertEqual(self.files(), ["samples.csv"])
        self.assertTrue((self.directory / "samples.csv").is_symlink())
        self.assertTrue(pathlib.Path("/dev/full").is_char_device())

    def test_overrides_that_are_none(self):
        for share in ("0", "-5", "200.1", "nan", "fast"):
            with self.subTest(share):
                self.check_refused(self.run_program("plan", CONTOUR, "--override", share), 2, "--override")


if __name__ == "__main__":
    unittest.main()
