"""Groups whose axes are the joints of a machine: the delta of the examples and a SCARA, by script and by commands, and their sentences."""
import json
import math
import signal
import unittest

from program import DISTURBED, EXAMPLES, PATIENCE_S, WATCHDOG, ProgramTest, again_when, patient

undisturbed = again_when(*DISTURBED, WATCHDOG, "no longer renews its lease", "the master was away")
DELTA = (EXAMPLES / "delta.toml").read_text(encoding="utf-8")
MOVES = (EXAMPLES / "delta.jsonl").read_text(encoding="utf-8").splitlines(keepends=True)
START = "robot enable\nwait robot\nrobot move 0 0 -560 feed=500\nwait robot\n"
KINEMATICS = 'kinematics = { type = "delta", unit = "mm", base_radius = 200, platform_radius = 45, upper_arm = 250, rod = 600 }'
ARM = ('{ type = "scara", unit = "mm", upper_arm = 350, forearm = 250, elbow_left = true }')


def scara_line():
    text = '[line]\nname = "arm"\ncycle_us = 1000\n[realtime]\npolicy = "degrade"\n[bus]\nmax_lost_cycles = 1000\n[telemetry]\nenabled = false\n'
    text += "".join(f'[[slave]]\nname = "{name}"\n' for name in ("shoulder", "elbow", "lift", "wrist"))
    for name in ("shoulder", "elbow", "lift", "wrist"):
        unit = 'feed_mm_per_revolution = 20\nunit = "mm"\nmax_velocity = 500\nmax_acceleration = 5000\nmax_jerk = 100000\n' if name == "lift" else \
            'unit = "deg"\nmax_velocity = 360\nmax_acceleration = 3600\nmax_jerk = 90000\n'
        text += f'[[axis]]\nname = "{name}"\n{unit}' + ("min_position = -120\nmax_position = 120\n" if name == "shoulder" else "")
    return text + f'[[axis_group]]\nname = "arm"\naxes = ["shoulder", "elbow", "lift", "wrist"]\nkinematics = {ARM}\ntool = {{ max_velocity = 800 }}\n'


def tool_of(shoulder, elbow):
    """Of the SCARA, mm, by the angles of its arms in degrees."""
    first, both = math.radians(shoulder), math.radians(shoulder + elbow)
    return 350 * math.cos(first) + 250 * math.cos(both), 350 * math.sin(first) + 250 * math.sin(both)


class Script(ProgramTest):
    """On virtual time."""

    def run_script(self, script, *arguments, line=DELTA, moves=None):
        self.write("line.toml", line)
        self.write("script.txt", script)
        if moves is not None:
            self.write("moves.jsonl", moves)
        return self.run_program("run", "--config", "line.toml", "--script", "script.txt", "--virtual", "--no-plots", *arguments)

    def check_wrong(self, result, status, sentence):
        self.assertEqual(result.returncode, status, result.stderr)
        self.assertIn(sentence, result.stderr.splitlines()[-1])

    def columns(self, *names):
        lines = self.text("out/axes.csv").splitlines()
        places = [lines[0].split(",").index(name) for name in names]
        return [[float(line.split(",")[place]) for place in places] for line in lines[1:]]

    def test_example_tells_where_its_tool_is(self):
        result = self.run_program("run", "--config", EXAMPLES / "delta.toml", "--script", EXAMPLES / "delta.txt", "--virtual", "--no-plots", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        group = document["axis_groups"][0]
        self.assertEqual((group["name"], group["state"], group["axes"]), ("robot", "GroupDisabled", ["a1", "a2", "a3"]))
        self.assertEqual(group["kinematics"], {"type": "delta", "unit": "mm", "base_radius": 200, "platform_radius": 45, "upper_arm": 250, "rod": 600})
        self.assertEqual([coordinate["name"] for coordinate in group["coordinates"]], ["x", "y", "z"])
        for coordinate, place in zip(group["coordinates"], (0, 0, -560)):
            self.assertAlmostEqual(coordinate["setpoint"], place, places=5)
            self.assertEqual(coordinate["unit"], "mm")
        for words in ("group robot: move to x 0 mm, y 0 mm, z -560 mm, feed 500 mm/s", "group robot: path",
                      "group robot: move on an arc to x 0 mm, y 0 mm, z -560 mm via x 50 mm, y 50 mm, z -580 mm"):
            self.assertTrue(any(words in event for event in document["events"]), document["events"])

    def test_an_arm_goes_straight_with_its_tool(self):
        script = ("elbow move 60\nwait elbow\narm enable\nwait arm\narm move 450 -100 -50 30deg feed=300\nwait arm\n"
                  "arm move-by 0 250 20 - feed=600\nwait arm\n")
        result = self.run_script(script, "--json", line=scara_line())
        self.assertEqual(result.returncode, 0, result.stderr)
        group = self.one_document(result.stdout)["axis_groups"][0]
        self.assertEqual([(each["name"], each["unit"]) for each in group["coordinates"]],
                         [("x", "mm"), ("y", "mm"), ("z", "mm"), ("c", "deg")])
        for each, place in zip(group["coordinates"], (450, 150, -30, 30)):
            self.assertAlmostEqual(each["setpoint"], place, places=5)
        joints = self.columns("shoulder_target[deg]", "elbow_target[deg]", "lift_target[mm]", "wrist_target[deg]")
        tools = [tool_of(shoulder, elbow) for shoulder, elbow, _, _ in joints]
        begin = next(k for k, tool in enumerate(tools) if math.dist(tool, (450, -100)) < 1e-3)
        self.assertLess(max(abs(tool[0] - 450) for tool in tools[begin:]), 1e-3)
        self.assertLess(max(abs(sum(joint[i] for i in (0, 1, 3)) - 30) for joint in joints[begin:]), 3e-4, "c stays")
        speeds = [math.dist(a, b) / 0.001 for a, b in zip(tools[begin:], tools[begin + 1:])]
        self.assertLessEqual(max(speeds), 600.5)
        self.assertGreater(max(speeds), 500)
        self.assertLess(math.dist(tools[-1], (450, 150)), 1e-3)

    def test_places_that_the_machine_cannot_have_are_refused_and_nothing_moves(self):
        for move, sentence in (
                ("0 0 -900", "group robot: the machine cannot reach (0, 0, -0.9): chain 1 is too short or too long for it"),
                ("600 0 -620", "group robot: the machine cannot reach"),
                ("0 0 -342", "group robot: axis a1 would be at"), ("0 0 -342", "deg, beyond its lowest position of -30 deg")):
            with self.subTest(move):
                self.check_wrong(self.run_script(START + f"robot move {move}\n"), 1, sentence)
                self.assertIn("script.txt:5: ", self._result_line())
        self.check_wrong(self.run_script("robot move 1 2\n"), 2, "script.txt:1: group robot: move: 3 positions are expected, of x, y, z")
        self.check_wrong(self.run_script("robot move 1 2 3deg\n"), 2, 'script.txt:1: position "3deg": axis z has no unit "deg"')
        arm = "elbow move {}\nwait elbow\narm enable\nwait arm\n"
        self.check_wrong(self.run_script(arm.format(0.5) + "arm move 450 0 0 0\nwait arm\n", line=scara_line()), 1,
                         "group arm: the path reaches a singular position of the machine at (0.59999, 0.00218163, 0, 0.00872665): the arms would be stretched or folded there")
        self.check_wrong(self.run_script(arm.format(-60) + "arm move 450 0 0 0\nwait arm\n", line=scara_line()), 1,
                         "is at a position that does not match the machine with its tool there")
        self.check_wrong(self.run_script(arm.format(60) + "arm move -450 50 0 0\nwait arm\n", line=scara_line()), 1, "group arm: axis shoulder would be at")

    def _result_line(self):
        return self.last.stderr.splitlines()[-1]

    def run_program(self, *words, **more):
        self.last = super().run_program(*words, **more)
        return self.last

    def test_files_are_checked_as_a_whole(self):
        head = MOVES[0]
        for first, move, sentence in (
                (head, '{"line": [0, 0, -900]}\n', "moves.jsonl:3: the machine cannot reach"),
                (head, '{"line": [0, 0, -342]}\n', "moves.jsonl:3: axis a1 would be at"),
                (head, '{"line": [0, 0, -570], "outputs": [{"name": "vacuum", "value": 2}]}\n',
                 "moves.jsonl:3: group robot: the value of vacuum is 2, a whole number from 0 to 1 is expected"),
                (head.replace('"vacuum", "blow"', '"suck"'), "", 'moves.jsonl:1: group robot has no output "suck"; it has vacuum, blow'),
                (head.replace('"rod": 600', '"rod": 610'), "", "moves.jsonl:1: the machine of the file differs from that of group robot: rod is 610 mm, not 600 mm"),
                (head.replace('"start": [0, 0, -560]', '"start": [5, 0, -560]'), "",
                 "moves.jsonl:1: the path starts at x 5 mm, but the group is at 0 mm; move the group there, or omit start")):
            with self.subTest(sentence):
                result = self.run_script(START + "robot path moves.jsonl\n", moves=first + '{"line": [0, 0, -561]}\n' + move)
                self.check_wrong(result, 2, sentence)
                self.assertLess(max(abs(a - b) for row in self.columns("a1_target[deg]", "a2_target[deg]")[-20:] for a, b in [row]), 1e-6)
        plain = json.loads(head)
        for key in ("kinematics", "outputs", "tool", "start"):
            del plain[key]
        self.check_wrong(self.run_script(START + "robot path moves.jsonl\n", moves=json.dumps(plain) + '\n{"line": [0, 0, 1]}\n'), 2,
                         "moves.jsonl:1: the file has no kinematics, but the moves of group robot are moves of the tool of a delta")
        without = DELTA[:DELTA.index("output = [")] + "[telemetry]\nenabled = false\n"
        self.check_wrong(self.run_script(START + "robot path moves.jsonl\n", line=without, moves="".join(MOVES)), 2,
                         "moves.jsonl:1: group robot has no outputs ([[axis_group.output]])")

    def test_units_of_a_file_are_its_own(self):
        head = json.loads(MOVES[0])
        head["kinematics"] = {"type": "delta", "unit": "m", "base_radius": 0.2, "platform_radius": 0.045, "upper_arm": 0.25, "rod": 0.6}
        head["tool"] = {"max_velocity": 6}
        del head["start"]
        result = self.run_script(START + "robot path moves.jsonl\nwait robot\n", "--json", moves=json.dumps(head) + '\n{"line": [0.05, 0, -0.58], "feed": 1}\n')
        self.assertEqual(result.returncode, 0, result.stderr)
        places = [each["setpoint"] for each in self.one_document(result.stdout)["axis_groups"][0]["coordinates"]]
        self.assertLess(math.dist(places, (50, 0, -580)), 1e-5)

    def test_acceleration_along_the_path_is_limited_without_a_machine_as_well(self):
        axes = "".join(f'[[slave]]\nname = "{name}"\n[[axis]]\nname = "{name}"\nfeed_mm_per_revolution = 20\nunit = "mm"\nmax_velocity = 800\n'
                       'max_acceleration = 8000\nmax_jerk = 400000\n' for name in "xy")
        line = ('[line]\ncycle_us = 1000\n[realtime]\npolicy = "degrade"\n[telemetry]\nenabled = false\n' + axes +
                '[[axis_group]]\nname = "table"\naxes = ["x", "y"]\ntool = { max_velocity = 300, max_acceleration = 1500, max_jerk = 60000 }\n')
        result = self.run_script("table enable\nwait table\ntable move-by 90 120\nwait table\n", line=line)
        self.assertEqual(result.returncode, 0, result.stderr)
        # Every fifth cycle: differences of positions with seven digits are grainy.
        places = self.columns("x_target[mm]", "y_target[mm]")[::5]
        values = [math.dist(place, places[0]) for place in places]
        self.assertAlmostEqual(values[-1], 150, delta=1e-3)
        for most, grain in ((300, 0.1), (1500, 20), (60000, 4000)):
            values = [(after - before) / 0.005 for before, after in zip(values, values[1:])]
            largest = max(map(abs, values))
            self.assertLessEqual(largest, most + grain)
            self.assertGreater(largest, 0.9 * most)

    def test_outputs_that_are_not_there_or_that_others_write(self):
        for before, after, sentence in (
                ('to = "a1.60FE:01", bit = 17', 'to = "a1.60FF", bit = 1', "[axis_group 1.output 2] to: "),
                ('to = "a1.60FE:01", bit = 17', 'to = "a1.208F", bit = 1', "is an input, an output is expected"),
                ('to = "a1.60FE:01", bit = 17', 'to = "a1.607A", bit = 1', 'is written by the axis "a1"'),
                ('to = "a1.60FE:01", bit = 17', 'to = "a1.60FE:01"', 'is already written by the output "vacuum"')):
            with self.subTest(after):
                result = self.run_script(START, line=DELTA.replace(before, after))
                self.assertNotEqual(result.returncode, 0)
                self.assertIn(sentence, result.stderr)
                self.assertIn("line.toml:", result.stderr)


class Hand(ProgramTest):
    """A run in real time and commands that speak to it."""

    def group(self, *words):
        return self.run_program("group", "arm", *words)

    @undisturbed
    def test_tool_is_moved_by_commands(self):
        self.write("line.toml", patient(scara_line()))
        run = self.start("run", "--config", "line.toml", "--no-plots", "--json", log="run.log")
        self.wait_for("the line in operation", lambda: "there is no [path]" in self.text("run.log"), run)
        self.wait_for("the elbow", lambda: "Standstill" in self.run_program("axis", "elbow", "status").stdout)
        self.assertEqual(self.run_program("axis", "elbow", "move", "60deg").returncode, 0)
        self.assertEqual(self.group("enable").returncode, 0)
        moved = self.group("move", "450", "0.1m", "0", "0", "--feed", "300mm/s")
        self.assertEqual((moved.returncode, moved.stdout), (0, "group arm: GroupStandby at x 450 mm, y 100 mm, z 0 mm, c 0 deg\n"), moved.stderr)
        self.check_refused(self.group("move", "700", "0", "0", "0"), 1, "group arm: the machine cannot reach (0.7, 0, 0, 0): the arms reach from 0.1 m to 0.6 m")
        head = {"kinematics": {"type": "scara", "unit": "mm", "upper_arm": 350, "forearm": 250, "elbow_left": True}, "tool": {"max_velocity": 800},
                "axes": [{"name": name, "unit": "mm" if name == "lift" else "deg", "max_velocity": 300, "max_acceleration": 3000, "max_jerk": 90000}
                         for name in ("shoulder", "elbow", "lift", "wrist")]}
        self.write("way.jsonl", json.dumps(head) + '\n{"line": [400, 100, 0, 0], "tolerance": 5}\n{"line": [400, 0, -20, 45]}\n')
        path = self.group("path", "way.jsonl", "--json")
        self.assertEqual(path.returncode, 0, path.stderr)
        group = self.one_document(path.stdout)["groups"][0]
        self.assertLess(math.dist([each["setpoint"] for each in group["coordinates"]], (400, 0, -20, 45)), 1e-5)
        x, y = tool_of(group["axes"][0]["setpoint"], group["axes"][1]["setpoint"])
        self.assertLess(math.dist((x, y), (400, 0)), 1e-5)
        head["kinematics"]["elbow_left"] = False
        self.write("other.jsonl", json.dumps(head) + '\n{"line": [400, 100, 0, 0]}\n')
        self.check_refused(self.group("path", "other.jsonl"), 2, "other.jsonl:1: the machine of the file differs from that of group arm: elbow_left is false, not true")
        self.assertIn("joints        shoulder ", self.group("status").stdout)
        self.assertIn("group arm (scara: shoulder, elbow, lift, wrist): GroupStandby at x 400 mm, y ", self.run_program("diag").stdout)
        self.assertEqual(self.group("disable").returncode, 0)
        self.end(run)

    def end(self, run):
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())

    @undisturbed
    def test_path_with_outputs_is_told_to_a_running_line(self):
        self.write("line.toml", patient(DELTA.replace("cycle_us = 500", "cycle_us = 2000")))
        run = self.start("run", "--config", "line.toml", "--no-plots", "--json", log="run.log")
        self.wait_for("the line in operation", lambda: "there is no [path]" in self.text("run.log"), run)
        self.wait_for("the axes", lambda: "Standstill" in self.run_program("axis", "a3", "status").stdout)
        for words in (("enable",), ("move", "0", "0", "-560", "--feed", "500"), ("path", EXAMPLES / "delta.jsonl")):
            result = self.run_program("group", "robot", *words)
            self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout, "group robot: GroupStandby at x 0 mm, y 0 mm, z -560 mm\n")
        status = self.one_document(self.run_program("group", "robot", "status", "--json").stdout)["groups"][0]
        self.assertEqual(status["outputs"], [{"name": name, "minimum": 0, "maximum": 1} for name in ("vacuum", "blow")])
        self.end(run)


if __name__ == "__main__":
    unittest.main()
