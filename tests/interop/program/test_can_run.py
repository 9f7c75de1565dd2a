"""A CAN line that `run` drives: on virtual time, over slcan at a line that is served, and refusals."""
import json
import re
import shutil
import signal
import socket
import subprocess
import threading

from program import AXES, DRIVELINE, EXAMPLES, PATIENCE_S, ProgramTest, again_when_disturbed, patient

CAN8 = EXAMPLES / "can8.toml"
TWO = """
[line]
name = "two"
[bus]
type = "can"
sync_ms = 4
max_lost_ms = 400
[realtime]
policy = "degrade"
[telemetry]
enabled = false
[output]
plots = false
{path}
[[slave]]
name = "x"
node = 3
[[slave]]
name = "y"
node = 5
[[axis]]
name = "x"
unit = "deg"
[[axis]]
name = "y"
"""
PATH = """[path]
file = "two.csv"
relative = true
"""


class CanLineOnVirtualTime(ProgramTest):
    def run_example(self, name):
        folder = self.directory / name
        folder.mkdir()
        result = subprocess.run([DRIVELINE, "run", "--config", CAN8, "--virtual", "--duration", "1", "--json",
                                 "--no-telemetry", "--no-plots", "--capture", "can.log"],
                                cwd=folder, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.one_document(result.stdout), (folder / "can.log").read_bytes()

    def test_the_example_runs_twice_with_the_same_frames(self):
        first, first_log = self.run_example("first")
        second, second_log = self.run_example("second")
        self.assertEqual(first, second)
        self.assertEqual(first_log, second_log)
        self.assertEqual(first["state"], "Operational")
        self.assertEqual([axis["name"] for axis in first["axes"]], AXES)
        self.assertEqual((first["cycle_ns"], first["cycles"]), (2_000_000, 500))
        for key in ("missed_periods", "wkc_errors", "lost_frames"):
            self.assertEqual(first[key], 0, key)
        bus = first["can"]
        self.assertEqual(bus["bit_rate"], 1_000_000)
        self.assertEqual((bus["lost_pdos"], bus["late_pdos"], bus["emergencies"]), (0, 0, 0))
        self.assertTrue(0.7 < bus["bus_load_mean"] < bus["worst_load"] < 0.88, bus)

    def test_commands_of_a_script_move_axes(self):
        self.write("two.toml", TWO.format(path=""))
        self.write("moves.txt", "x move 90deg\nwait x\ny move by=1rad velocity=4rad/s\ny jog 2rad/s\nsleep 0.2s\ny halt\nwait all\n")
        result = self.run_program("run", "--config", self.directory / "two.toml", "--virtual", "--script",
                                  self.directory / "moves.txt", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(self.one_document(result.stdout)["faults"], [])


class CanLineOverSlcan(ProgramTest):
    def serve(self, config):
        line = self.start("simulate", "--config", config, "--slcan", "127.0.0.1:0", "--control", "line.socket",
                          log="line.log")
        self.wait_for("the line is served", lambda: "Ctrl-C ends the program" in self.text("line.log"), line)
        return line, int(re.search(r"slcan at 127\.0\.0\.1:(\d+)", self.text("line.log"))[1])

    def test_two_axes_follow_their_path_at_a_served_line(self):
        self.write("two.csv", "time[s],x[deg],y[rad]\n0,0,0\n0.5,30,1\n1,0,0\n")
        self.write("two.toml", TWO.format(path=PATH))
        config = self.directory / "two.toml"
        line, port = self.serve(config)
        result = self.run_program("run", "--config", config, "--iface", f"slcan:tcp:127.0.0.1:{port}", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual(document["state"], "Operational")
        self.assertEqual(document["interfaces"][0]["name"], f"slcan:tcp:127.0.0.1:{port}")
        self.assertGreater(document["can"]["frames_received"], 500)
        self.assertEqual(document["faults"], [])
        line.send_signal(signal.SIGTERM)
        self.assertEqual(line.wait(PATIENCE_S), 0)


    def run_at(self, port):
        """A run along a path that has no end, which is following it."""
        self.write("two.csv", "time[s],x[deg],y[rad]\n0,0,0\n0.5,30,1\n1,0,0\n")
        config = self.write("two.toml", TWO.format(path=PATH + "repeat = true\n"))
        run = self.start("run", "--config", config, "--iface", f"slcan:tcp:127.0.0.1:{port}", "--json", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        return run

    def test_an_adapter_that_is_unplugged_ends_the_run(self):
        self.write("served.toml", TWO.format(path=""))
        line, port = self.serve(self.directory / "served.toml")
        run = self.run_at(port)
        line.kill()
        self.assertEqual(run.wait(PATIENCE_S), 1, self.text("run.log"))
        self.assertEqual(self.text("run.log").splitlines()[-1], "driveline run: the CAN adapter or its connection is gone")
        self.assertNotIn("all in Pre-operational\n", self.text("run.log").split("all in Operational")[1], "nobody has heard it")

    @again_when_disturbed
    def test_garbage_of_the_adapter_is_passed_over(self):
        """Between its lines an adapter sends bytes that are none of the protocol."""
        self.write("served.toml", TWO.format(path=""))
        _, port = self.serve(self.directory / "served.toml")
        with GarbledConnection(port) as garbled:
            run = self.run_at(garbled.port)
            self.wait_for("some garbage", lambda: garbled.pieces >= 200, run)
            run.send_signal(signal.SIGINT)
            self.assertEqual(run.wait(PATIENCE_S), 0, self.text("run.log"))
        document = self.one_document(self.text("run.log.out"))
        self.assertEqual((document["faults"], document["state"]), ([], "Operational"))


class GarbledConnection:
    """A connection to a port, which puts garbage behind some lines that come from there."""

    GARBAGE = (b"\x00\xff\xfe\r", b"t1\r", b"t99999\r", b"T0000018380011223344556677\r", b"\x07\x07", b"xyzzy\r", b"t1838\r")

    def __init__(self, port):
        self.pieces = 0
        self.there = socket.create_connection(("127.0.0.1", port))
        self.door = socket.create_server(("127.0.0.1", 0))
        self.port = self.door.getsockname()[1]
        self.thread = threading.Thread(target=self.serve, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        for end in (self.there, self.door):
            end.close()
        self.thread.join(PATIENCE_S)

    def serve(self):
        here, _ = self.door.accept()
        here.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        back = threading.Thread(target=self.pass_on, args=(here, self.there), daemon=True)
        back.start()
        try:
            while data := self.there.recv(4096):
                here.sendall(data)
                if data.startswith(b"t") and data.endswith(b"\r"):
                    here.sendall(self.GARBAGE[self.pieces % len(self.GARBAGE)])
                    self.pieces += 1
        except OSError:
            pass
        here.close()
        back.join(PATIENCE_S)

    @staticmethod
    def pass_on(source, target):
        try:
            while data := source.recv(4096):
                target.sendall(data)
        except OSError:
            pass


class ExamplesOfEtherCat(ProgramTest):
    """Examples of EtherCAT lines run on a CAN bus: only their tables [bus] differ, and the cycle where the bus is too slow for it."""

    def run_on_can(self, name, script, cycle_us=None):
        text = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8").replace("[bus]\n", '[bus]\ntype = "can"\n')
        if cycle_us is not None:
            text = re.sub(r"(?m)^cycle_us = \d+$", f"cycle_us = {cycle_us}", text)
        self.write(f"{name}.toml", text)
        for file in script, "contour.jsonl":
            shutil.copy(EXAMPLES / file, self.directory)
        result = self.run_program("run", "--config", self.directory / f"{name}.toml", "--virtual", "--no-plots", "--json", "--script",
                                  self.directory / script)
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual((document["faults"], document["state"]), ([], "Operational"))
        self.assertEqual(document["can"]["lost_pdos"], 0)
        return document, result.stderr

    def test_a_group_draws_its_contour(self):
        document, told = self.run_on_can("plotter", "plotter.txt")
        self.assertEqual(document["axis_groups"], [{"name": "plotter", "axes": ["x", "y"], "state": "GroupDisabled", "owner": "script"}])
        self.assertIn("script: group plotter: path", told)

    def test_a_saw_follows_its_material_by_a_gear(self):
        _, told = self.run_on_can("flying_saw", "flying_saw.txt", cycle_us=2000)
        self.assertIn("axis saw: gear-in at=500mm to=60mm over=120mm", told)

    def test_a_controller_by_torque_is_refused_with_what_to_use_instead(self):
        text = (EXAMPLES / "own_controller.toml").read_text(encoding="utf-8")
        self.write("own_controller.toml", '[bus]\ntype = "can"\n' + text)
        result = self.run_program("run", "--config", self.directory / "own_controller.toml", "--virtual")
        self.check_refused(result, 2, "own_controller.toml", "mode 10 is EtherCAT only (MSD manual 2077-2079); use interpolated position")


class CanLinesThatAreRefused(ProgramTest):
    def test_each_has_a_sentence(self):
        self.write("two.toml", TWO.format(path=""))
        two = self.directory / "two.toml"
        rows = (
            (("--iface", "slcan:tcp:127.0.0.1:1"), "a CAN line needs its description: --config FILE"),
            (("--config", EXAMPLES / "line8.toml", "--iface", "slcan:tcp:127.0.0.1:1"), "describes a line of EtherCAT"),
            (("--config", two, "--mode", "csp"), "mode 8 is EtherCAT only (MSD manual 2077-2079); use interpolated position"),
            (("--config", two, "--iface", "slcan:tcp:127.0.0.1:1", "--virtual"), "has no virtual time"),
            (("--config", two, "--iface", "slcan:tcp:127.0.0.1:1"), "127.0.0.1:1"),
            (("--config", two, "--iface2", "eth1"), "a CAN bus is none"),
        )
        for arguments, sentence in rows:
            with self.subTest(sentence):
                result = self.run_program("run", *arguments)
                self.assertNotEqual(result.returncode, 0)
                self.assertIn(sentence, result.stderr)

    def test_a_line_that_is_too_much_for_its_bus(self):
        text = CAN8.read_text().replace("sync_ms = 2 ", "sync_ms = 1 ")
        self.write("line8.csv", (EXAMPLES / "line8.csv").read_text())
        self.write("fast.toml", text)
        result = self.run_program("run", "--config", self.directory / "fast.toml", "--virtual", "--no-telemetry")
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("8 axes need 1.74 ms of bus in the worst case, SYNC is 1 ms: take 2 ms, or 3 axes", result.stderr)
