"""What the tests of the CANopen master on served buses share: a bus, devices of other makes on it, and descriptions of their line."""
import json
import re
import signal
import subprocess
import sys

from program import PATIENCE_S, ROOT, ProgramTest

SHEET = ROOT / "tests/interop/canopen/drive.eds"
NODE = 9  # of the devices of other makes
TURNS = 0.25


def python_with_can():
    """An interpreter that has python-can; None: it is not installed."""
    for interpreter in ("/usr/bin/python3", sys.executable):
        if subprocess.run([interpreter, "-c", "import can, serial"], capture_output=True, check=False).returncode == 0:
            return interpreter
    return None


class CanMasterTest(ProgramTest):
    """A test with a bus that is served, on which `run` is one client among others."""

    def serve(self, config, *arguments, log="line.log"):
        """Serves the simulated line of a description; the port of its slcan door."""
        self.server = self.start("simulate", "--config", config, "--slcan", "127.0.0.1:0", *arguments, log=log)
        self.wait_for("the line is served", lambda: "Ctrl-C ends the program" in self.text(log), self.server)
        return int(re.search(r"slcan at 127\.0\.0\.1:(\d+)", self.text(log))[1])

    def serve_bystander(self):
        """A bus with a drive that is not planned, so that the frames of two others are acknowledged whoever comes first."""
        return self.serve(self.write("bus.toml", '[bus]\ntype = "can"\n[[slave]]\nname = "bystander"\nnode = 100\n'))

    def foreign_line(self, sync_ms=10, slave="", head="", tail=""):
        """A line description with one drive, known by its data sheet, that swings TURNS and comes back."""
        self.write("swing.csv", f"time[s],x[rev]\n0,0\n0.5,{TURNS}\n1,0\n")
        return self.write("foreign.toml", f"""
[bus]
type = "can"
sync_ms = {sync_ms}
max_lost_cycles = 40
[realtime]
policy = "degrade"
[telemetry]
enabled = false
[path]
file = "swing.csv"
relative = true
{head}
[[slave]]
name = "x"
node = {NODE}
model = "eds"
eds = "{SHEET}"
{slave}
[[axis]]
name = "x"
increments_per_revolution = 65536
inertia = 1.0e-4
{tail}
""")

    def run_line(self, config, port, *arguments):
        """Runs a line over the slcan door; the result, and its document if there is one."""
        result = self.run_program("run", "--config", config, "--iface", f"slcan:tcp:127.0.0.1:{port}", "--json", "--no-plots",
                                  *arguments)
        return result, json.loads(result.stdout) if result.stdout else None

    def start_device(self, *command, log):
        """A device of another make, which tells what it has seen when its input ends."""
        device = self.start(*command[1:], program=command[0], log=log, stdin=subprocess.PIPE)
        self.addCleanup(device.stdin.close)
        return device

    def end_device(self, device, log):
        device.stdin.close()
        self.assertEqual(device.wait(PATIENCE_S), 0, self.text(log))
        return json.loads(self.text(f"{log}.out"))

    def upload(self, port, node, index, subindex=0):
        """A number of a node, read by a tool."""
        result = self.run_program("upload", "--iface", f"slcan:tcp:127.0.0.1:{port}", "-n", node, hex(index), subindex, "-t", "raw")
        if result.returncode != 0:
            return None
        return int.from_bytes(bytes(int(byte, 16) for byte in result.stdout.split()), "little")

    @staticmethod
    def kill_hard(process):
        process.send_signal(signal.SIGKILL)
        process.wait(PATIENCE_S)
