"""The commands that the documents show work as they stand there."""
import re
import shlex
import signal
import unittest

from program import ATTEMPTS, PATIENCE_S, ROOT, ProgramTest, WireTest, patient, shortened, was_disturbed

DOCUMENTS = ("README.md", "docs/command_line.md")


def commands():
    """Every `driveline` command of the shell examples, as a list of its arguments."""
    found = []
    for document in DOCUMENTS:
        text = (ROOT / document).read_text(encoding="utf-8")
        for language, block in re.findall(r"^```(\w*)\n(.*?)^```", text, re.M | re.S):
            for line in block.splitlines() if language in ("", "sh") else ():
                words = shlex.split(line, comments=True)
                if ">" in words:
                    words = words[:words.index(">")]
                if words and words[0] in ("driveline", "build/driveline") and words[1:] not in found:
                    found.append(words[1:])
    return found


def documented_keys():
    """Keys of the line description by table, as the reference lists them."""
    text = (ROOT / "docs/command_line.md").read_text(encoding="utf-8")
    text = text.partition("\n## Line descriptions\n")[2].partition("\n## ")[0]
    keys = {}
    table = None
    for line in text.splitlines():
        heading = re.match(r"(?:### |`)\[\[?([\w.]+)\]\]?", line)
        row = re.match(r"\| ((?:`\w+`(?:, )?)+) \|", line)
        if heading:
            table = heading[1]
        elif row:
            keys.setdefault(table, set()).update(re.findall(r"\w+", row[1]))
    return keys


class DocumentTest(ProgramTest):
    def setUp(self):
        super().setUp()
        (self.directory / "examples").symlink_to(ROOT / "examples")

    def check(self, arguments, disturbed=was_disturbed):
        with self.subTest(command=" ".join(arguments)):
            result = self.run_undisturbed(*shortened(arguments), disturbed=disturbed)
            self.assertEqual(result.returncode, 0, result.stderr)
            if "--json" in arguments:
                self.one_document(result.stdout)


# What a run waits for, and what is said beside it.
WAITS = ["run", "--config", "examples/by_hand.toml", "--telemetry"]
BESIDE_IT = ("axis", "echo", "record", "top")


def goes_by_itself(arguments):
    return "--iface" not in arguments and arguments != WAITS and arguments[0] not in BESIDE_IT


class Examples(unittest.TestCase):
    def test_have_as_many_lines_as_the_documents_say(self):
        lines = [len(file.read_text(encoding="utf-8").splitlines()) for file in (ROOT / "examples").glob("*.cpp")]
        for document in ("README.md", "docs/reference.md", "examples/README.md"):
            text = " ".join((ROOT / document).read_text(encoding="utf-8").split())
            told = re.search(r"programs(?: have| of| in `examples/`, of) (\d+) to (\d+) lines", text)
            self.assertIsNotNone(told, document)
            self.assertEqual((int(told[1]), int(told[2])), (min(lines), max(lines)), document)


class InProcess(DocumentTest):
    def test_commands_run(self):
        shown = [arguments for arguments in commands() if goes_by_itself(arguments)]
        self.assertGreater(len(shown), 5)
        for arguments in shown:
            self.check(arguments)


TERMINAL = '[[slave]]\nname = "x"\nesi = "examples/terminals.xml"\ndevice = "AI2"'


class Reference(DocumentTest):
    # Complete enough for the reader to come to the key that is wrong.
    TABLES = {
        "line": ["[line]"],
        "bus": ["[bus]"],
        "realtime": ["[realtime]"],
        "slave": ['[[slave]]\nname = "x"', TERMINAL],
        "slave.plant": ['[[slave]]\nname = "x"\n[slave.plant]'],
        "slave.plant.dc_link": ['[[slave]]\nname = "x"\n[slave.plant.dc_link]'],
        "slave.plant.encoder": ['[[slave]]\nname = "x"\n[slave.plant.encoder]'],
        "slave.plant.load": ['[[slave]]\nname = "x"\n[slave.plant.load]'],
        "slave.plant.thermal": ['[[slave]]\nname = "x"\n[slave.plant.thermal]'],
        "slave.plant.winding": ['[[slave]]\nname = "x"\n[slave.plant.winding]'],
        "slave.switch": ['[[slave]]\nname = "x"\n[[slave.switch]]\ninput = "ISD00"\nto_rev = 1'],
        "slave.pdo": ['[[slave]]\nname = "x"\n[[slave.pdo]]\nindex = 0x1600'],
        "slave.startup": ['[[slave]]\nname = "x"\n[slave.startup]\nsafeop_retries = 3'],
        "slave.sdo": ['[[slave]]\nname = "x"\n[[slave.sdo]]\nindex = 0x2000\nvalue = "00"'],
        "slave.idn": ['[[slave]]\nname = "x"\n[[slave.idn]]\nnumber = "S-0-0044"\nvalue = 7'],
        "slave.input": [TERMINAL + f'\n[[slave.input]]\nentry = "6000:11"\n{shape}'
                        for shape in ("value = 1", 'shape = "ramp"\nperiod_s = 1',
                                      'shape = "steps"\nat_ms = [0]\nvalues = [1]')],
        "process_data": ['slave = [{ name = "x" }]\n[process_data]'],
        "group": ['slave = [{ name = "x" }]\n[[group]]\nname = "g"\nslaves = ["x"]'],
        "copy": ['slave = [{ name = "x" }]\n[[copy]]\nfrom = "x.6041h"\nto = "x.6040h"'],
        "eoe": ['slave = [{ name = "x", ip = "192.168.38.5" }]\n[eoe]\ninterface = "dl-eoe"\naddress = "192.168.38.1/24"'],
        "gateway": ['slave = [{ name = "x" }]\n[gateway]'],
        "commands": ['slave = [{ name = "x" }]\n[commands]'],
        "stream": ['slave = [{ name = "x" }]\n[stream]\nsocket = "/tmp/x"'],
        "dc": ['slave = [{ name = "x" }]\n[dc]'],
        "slave.dc": ['[[slave]]\nname = "x"\n[slave.dc]'],
        "wiring": ['slave = [{ name = "x" }, { name = "y" }]\n[wiring]\n' + preset
                   for preset in ("", 'preset = "star"', 'preset = "branch"\njunction = "x"\nbranch_slaves = 1')],
        "wiring.cable": ['slave = [{ name = "x" }]\n[[wiring.cable]]\nfrom = "master"\nto = "x:0"'],
        "axis": ['[[slave]]\nname = "x"\n[[axis]]\nname = "x"',
                 '[[slave]]\nname = "x"\n[[axis]]\nname = "x"\nfeed_mm_per_revolution = 5'],
        "virtual_axis": ['slave = [{ name = "x" }]\n[[virtual_axis]]\nname = "v"\nmax_velocity = 1\nmax_acceleration = 1'],
        "encoder": ['slave = [{ name = "x" }]\n[[encoder]]\nname = "e"\nposition = "x.6064h"\nincrements_per_revolution = 4096\n'
                    'max_velocity = 1'],
        "cam": ['slave = [{ name = "x" }]\n[[cam]]\nname = "c"\nfile = "c.csv"'],
        "coupling": ['slave = [{ name = "x" }, { name = "y" }]\naxis = [{ name = "x" }, { name = "y" }]\n[[coupling]]\nslave = "x"\nmaster = "y"'],
        "axis_group": ['slave = [{ name = "x" }, { name = "y" }]\naxis = [{ name = "x" }, { name = "y" }]\n[[axis_group]]\nname = "g"\n'
                       'axes = ["x", "y"]'],
        "axis_group.output": ['slave = [{ name = "x" }, { name = "y" }]\naxis = [{ name = "x" }, { name = "y" }]\n[[axis_group]]\nname = "g"\n'
                              'axes = ["x", "y"]\n[[axis_group.output]]\nname = "a"\nto = "x.60FE:01"'],
        "gantry": ['slave = [{ name = "x" }, { name = "y" }]\naxis = [{ name = "x" }, { name = "y" }]\n[[gantry]]\nleader = "x"\n'
                   'follower = "y"\nskew_limit = 1'],
        "path": ['slave = [{ name = "x" }]\n[path]\nfile = "a.csv"'],
        "recovery": ['slave = [{ name = "x" }]\n[recovery]'],
        "telemetry": ['slave = [{ name = "x" }]\n[telemetry]'],
        "telemetry.rates": ['slave = [{ name = "x" }]\n[telemetry.rates]'],
        "output": ['slave = [{ name = "x" }]\n[output]'],
    }

    INNER = ("axis_group.output", "slave.dc", "slave.idn", "slave.input", "slave.pdo", "slave.plant", "slave.plant.dc_link", "slave.plant.encoder", "slave.plant.load",
             "slave.plant.thermal", "slave.plant.winding", "slave.sdo", "slave.startup", "slave.switch", "slave.timeouts", "slave.watchdog", "telemetry.rates", "wiring.cable")

    def test_lists_the_keys_that_the_program_knows(self):
        documented = documented_keys()
        self.assertEqual(set(documented), set(self.TABLES))
        self.write("c.csv", "master[deg],slave[deg]\n0,0\n180,10\n360,0\n")
        for table, texts in self.TABLES.items():
            known = set()
            for text in texts:
                self.write("line.toml", text + "\nxyzzy = 1\n")
                complaint = self.run_program("slaves", "--config", "line.toml").stderr
                self.assertIn("xyzzy: unknown key, expected one of: ", complaint)
                known |= set(complaint.strip().partition("expected one of: ")[2].split(", "))
            # What is a table of its own is described as one.
            known -= {inner.rpartition(".")[2] for inner in self.INNER if inner.rpartition(".")[0] == table}
            self.assertEqual(documented[table], known, table)


class BesideARun(DocumentTest, WireTest):
    """In a network of its own: the commands show what all lines of DDS domain 0 publish."""

    @staticmethod
    def end_of(process):
        process.send_signal(signal.SIGINT)
        return process.wait(PATIENCE_S)

    def has_axes_that_wait(self, run):
        """Whether the axes come to take requests before the run is over."""
        takes = lambda: self.run_program("axis", "all", "status").stdout.count("Standstill") == 2
        self.wait_for("axes that take requests", lambda: takes() or run.poll() is not None)
        return run.poll() is None

    def start_what_waits(self):
        """The run as it is shown, and then one of the same line that a machine that stands still does not end."""
        for _ in range(ATTEMPTS):
            run = self.start(*WAITS, log="run.log")
            if self.has_axes_that_wait(run) and self.end_of(run) == 0:
                break
        self.assertEqual(run.returncode, 0, self.logs())
        line = self.write("patient.toml", patient((ROOT / WAITS[2]).read_text(encoding="utf-8")))
        run = self.start(*(line if word == WAITS[2] else word for word in WAITS), log="run.log")
        self.assertTrue(self.has_axes_that_wait(run), self.logs())
        return run

    @staticmethod
    def was_late(result):
        """Whether the command, or the run beside it, was suspended for longer than an axis waits for a sign of life."""
        return was_disturbed(result) or "no longer renews its lease" in result.stderr or "no sample arrived" in result.stderr

    def test_commands_beside_a_run(self):
        self.assertIn(WAITS, commands())
        run = self.start_what_waits()
        shown = [arguments for arguments in commands() if arguments[0] in BESIDE_IT]
        self.assertEqual({arguments[0] for arguments in shown}, set(BESIDE_IT))
        for arguments in shown:
            if arguments[0] == "top":
                page = self.start(*arguments, log="top.log")
                self.wait_for("a page", lambda: "OPERATION ENABLED" in self.text("top.log.out"), page)
                self.assertEqual(self.end_of(page), 0, self.logs())
            else:
                self.check(arguments, self.was_late)
        self.assertEqual(self.end_of(run), 0, self.logs())


class OnTheWire(DocumentTest, WireTest):
    def test_commands_run(self):
        shown = [arguments for arguments in commands() if "--iface" in arguments]
        served = [arguments for arguments in shown if arguments[0] == "simulate"]
        self.assertTrue(served)
        self.assertGreater(len(shown), len(served) + 2)
        self.start_line("examples/line8-nic.toml")
        for arguments in shown:
            if arguments not in served:
                self.check(arguments)


if __name__ == "__main__":
    unittest.main()
