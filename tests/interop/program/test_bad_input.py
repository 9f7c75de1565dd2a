"""Wrong usage and bad input: the exit status, one sentence, and nothing left behind."""
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import unittest

from program import AXES, DRIVELINE, EXAMPLES, PATIENCE_S, ROOT, SANITIZED, ProgramTest, WireTest, line_description, path_csv

LINE8 = EXAMPLES / "line8.toml"


class Usage(ProgramTest):
    def refused(self, status, arguments, *parts):
        with self.subTest(arguments=arguments):
            self.check_refused(self.run_program(*arguments), status, *parts)
            self.assertEqual(self.files(), [])

    def test_pdos_that_the_esi_file_does_not_allow(self):
        esi = ROOT / "esi/data/moog_msd.xml"
        config = self.write("line.toml", f'[bus]\nesi = ["{esi}"]\n[line]\ncycle_us = 1000\n[[slave]]\nname = "x"\n'
                            '[[slave.pdo]]\nindex = 0x1600\nsync_manager = 3\n')
        result = self.run_program("run", "--config", config, "--virtual", "--duration", "0.1", "--no-telemetry")
        self.assertEqual((result.returncode, result.stdout), (1, ""))
        self.assertIn("slave 0 (x): the planned PDOs cannot be configured by the ESI file of", result.stderr)
        self.assertIn("PDO 1600h is assigned to sync manager 3, which carries no outputs", result.stderr)

    AXIS = '[line]\ncycle_us = 1000\n[[slave]]\nname = "x"\n{}[[axis]]\nname = "x"\n'
    BY_INDEX = "[[slave.pdo]]\nindex = 0x1600\n[[slave.pdo]]\nindex = 0x1A00\n"

    def test_axis_whose_pdos_lack_what_its_mode_needs(self):
        # The simulated drive has empty PDOs until they are mapped.
        config = self.write("nothing.toml", self.AXIS.format(self.BY_INDEX))
        result = self.run_program("run", "--config", config, "--virtual", "--duration", "1", "--no-telemetry")
        self.assertEqual((result.returncode, result.stdout), (2, ""))
        for part in ("axis x, slave 0 (x): csp needs 6040h (Controlword, 16 bits) in an RxPDO",
                     "6064h (Position actual value, 32 bits)", "the TxPDOs map nothing"):
            self.assertIn(part, result.stderr)
        config = self.write("target.toml", self.AXIS.format(
            '[[slave.pdo]]\nindex = 0x1600\nentries = ["0x6040:0:16", "0x6060:0:8"]\n'
            '[[slave.pdo]]\nindex = 0x1A00\nentries = ["0x6041:0:16", "0x6061:0:8", "0x6064:0:32"]\n'))
        result = self.run_program("run", "--config", config, "--virtual", "--duration", "1", "--no-telemetry")
        self.check_refused(result, 2, "target.toml:11: [axis 1] slave: ", "csp needs 607Ah (Target position, 32 bits)")
        self.assertEqual(sorted(self.files()), ["nothing.toml", "target.toml"])

    def test_pdos_by_their_index_are_those_of_the_drive(self):
        def mapping(index, *objects):
            values = [(0, "uint8", 0)] + [(n + 1, "uint32", value) for n, value in enumerate(objects)]
            return "".join(f'[[slave.sdo]]\nindex = {index}\nsubindex = {sub}\ntype = "{kind}"\nvalue = {value}\n'
                           for sub, kind, value in values + [(0, "uint8", len(objects))])
        self.write("path.csv", "time[s],x[rad]\n0,0\n1,3\n")
        config = self.write("line.toml", self.AXIS.format(
            mapping(0x1600, 0x60400010, 0x607A0020) + mapping(0x1A00, 0x60410010, 0x60640020) + self.BY_INDEX) +
            '[path]\nfile = "path.csv"\nrelative = true\n')
        result = self.run_program("run", "--config", config, "--virtual", "--no-plots", "--no-telemetry")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("8 bytes of process data", result.stderr)
        actual = [float(row.split(",")[2]) for row in self.text("out/axes.csv").splitlines()[1:]]
        self.assertAlmostEqual(max(actual), 3.0, delta=0.01)

    def test_torque_mode_without_a_gain(self):
        config = self.write("line.toml", self.AXIS.format("") + 'mode = "cst"\n')
        result = self.run_program("run", "--config", config, "--virtual", "--duration", "1", "--no-telemetry")
        self.check_refused(result, 2, "line.toml:5: [axis 1] velocity_gain: ", "the axis would never move")

    def test_slots_of_an_esi_file_are_told_of(self):
        text = (EXAMPLES / "terminals.xml").read_text(encoding="utf-8")
        self.write("slots.xml", text.replace("</Device>", "<Slots><Slot/></Slots></Device>", 1))
        config = self.write("line.toml", '[[slave]]\nname = "x"\nesi = "slots.xml"\ndevice = "DI8"\n')
        result = self.run_program("slaves", "--config", config)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, r"slots\.xml:\d+: a device with slots: modules are not read from ESI files")

    def test_command_line(self):
        self.refused(2, [], "a command is missing", "--help")
        self.refused(2, ["walk"], "walk")
        self.refused(2, ["run", "--quickly"], "--quickly", "--help")
        self.refused(2, ["rnu"], "driveline: there is no command rnu; did you mean run?; driveline --help shows more")
        self.refused(2, ["run", "--confg", "x"], "driveline run: there is no option --confg; did you mean --config?; ")
        self.refused(2, ["esi", "shw"], "driveline esi: there is no command shw; did you mean show?; ")
        self.refused(2, ["run", LINE8], f"driveline run: {LINE8} was not expected; a line description is given as --config FILE; ")
        self.refused(2, ["run", "--duration"], "driveline run: --duration needs a value; driveline run --help shows more")
        self.refused(2, ["run"], "--config FILE", "--iface NAME")
        self.refused(2, ["run", "--config"], "--config")
        self.refused(2, ["slaves"], "--config FILE", "--iface NAME")
        self.refused(2, ["run", "--config", LINE8, "--telemetry", "--no-telemetry"], "--telemetry and --no-telemetry exclude each other")
        self.refused(2, ["run", "--iface", "lo", "--telemetry"], "--config FILE")
        self.refused(2, ["simulate", "--config", LINE8], "driveline simulate: needs --iface NAME: where to serve the line")
        self.refused(2, ["simulate", "--iface", "lo"], "driveline simulate: needs --config FILE: the line to simulate")
        self.assertIn("Network interface to serve the line on", self.run_program("simulate", "--help").stdout)
        for duration in ("-1", "soon", "nan", "inf", "1e9"):
            self.refused(2, ["run", "--config", LINE8, "--duration", duration], duration)
        self.refused(2, ["run", "--config", LINE8, "--virtual", "--iface", "lo"], "virtual time")
        self.refused(2, ["states", "--config", LINE8, "OP"], "run")
        self.refused(2, ["states", "--config", LINE8, "BOOT"], "BOOT", "single slaves")
        self.refused(2, ["upload", "--config", LINE8], "INDEX")
        self.refused(2, ["upload", "--config", LINE8, "0x12345", "0"], "0x12345")
        self.refused(2, ["upload", "--config", LINE8, "0x6041", "256"], "256")
        self.refused(2, ["upload", "--config", LINE8, "-p", "-1", "0x6041", "0"], "-1")
        self.refused(2, ["upload", "--config", LINE8, "-t", "word", "0x6041", "0"], "word", "uint16")
        self.refused(2, ["download", "--config", LINE8, "-t", "uint8", "0x6060", "0", "256"], "256", "uint8")

    def test_operation_that_fails(self):
        self.refused(1, ["slaves", "--iface", "nonexist0"], "nonexist0")
        self.refused(1, ["run", "--config", LINE8, "--iface", "nonexist0"], "nonexist0")
        self.refused(1, ["slaves", "--iface", "lo"], "loopback")
        self.refused(1, ["upload", "--config", LINE8, "-p", "8", "0x6041", "0"], "there is no slave 8")
        self.refused(1, ["upload", "--config", LINE8, "0x5FFF", "0"], "slave 0", "5FFFh", "0x06020000")
        self.refused(1, ["upload", "--config", LINE8, "6041", "0"], "1799h", "; 6041 is a decimal number, 0x6041 or 6041h a hex")
        self.refused(1, ["upload", "--config", LINE8, "-t", "int32", "0x6041", "0"], "2 bytes", "int32")
        self.refused(1, ["download", "--config", LINE8, "0x6041", "0", "0000"], "6041h", "0x0601000")

    def test_help_and_version_are_no_errors(self):
        for arguments in (["--help"], ["run", "--help"], ["esi", "show", "--help"], ["--version"]):
            with self.subTest(arguments=arguments):
                result = self.run_program(*arguments)
                self.assertEqual(result.returncode, 0)
                self.assertEqual(result.stderr, "")
                self.assertNotEqual(result.stdout, "")


class Files(ProgramTest):
    def refused(self, status, *parts, arguments=(), **description):
        """`run` of a line description with something wrong in it leaves nothing but that description."""
        path = self.write("line.toml", line_description(**description))
        before = self.files()
        result = self.run_program("run", "--config", path, "--virtual", "--duration", 0.1, "--capture", "c.pcapng",
                                  *arguments)
        self.check_refused(result, status, *parts)
        self.assertEqual(self.files(), before)

    def test_description_that_is_missing(self):
        self.check_refused(self.run_program("run", "--config", "none.toml"), 2, "none.toml", "No such file")
        self.assertEqual(self.files(), [])

    def test_description_that_is_no_toml(self):
        self.write("line.toml", "[line\n")
        self.check_refused(self.run_program("run", "--config", "line.toml"), 2, "line.toml:1: ")
        self.assertEqual(self.files(), ["line.toml"])

    def test_unknown_key(self):
        self.refused(2, "line.toml:", "[line] colour", "unknown key", tail="[line.colour]\n")

    def test_path_that_is_missing(self):
        self.refused(2, "none.csv", path="none.csv")

    def test_time_that_does_not_rise(self):
        self.refused(2, "path.csv:4:", path=self.write("path.csv", path_csv([(0, 0), (0.001, 0), (0.001, 0)])))

    def test_number_of_axes(self):
        self.refused(2, "path.csv", 'there is no column for axis "y"', path=self.write("path.csv", "time[s],x[rad]\n0,0\n1,0\n"))

    def test_limits(self):
        path = self.write("path.csv", path_csv([(0, 0), (1, 10000), (2, 0)]))
        self.refused(2, "path.csv", "'x'", "limit", path=path)

    def test_software_limits(self):
        path = self.write("path.csv", path_csv([(0, 0), (1, 2), (2, 0)]))
        self.refused(2, "path.csv", f'axis "{AXES[-1]}" would go to 2 rad at 1 s; its max_position is 1.5 rad', path=path,
                     tail="min_position = -1\nmax_position = 1.5\n")
        self.refused(2, "line.toml:", "max_position: is -1 rad, more than the 1 rad of min_position is expected",
                     tail="min_position = 1\nmax_position = -1\n")

    def test_folder_that_cannot_be_made(self):
        self.write("out", "a file")
        self.refused(1, "out", arguments=["--no-telemetry"])

    def test_telemetry_that_cannot_start(self):
        self.refused(1, "telemetry", telemetry='interfaces = ["not an address"]')

    def test_another_drive_than_expected(self):
        # Found out on the bus, so the progress of the scan stands before the sentence.
        text = line_description().replace('name = "z"\n', 'name = "z"\nproduct_code = 0x1234\n', 1)
        path = self.write("line.toml", text)
        result = self.run_program("run", "--config", path, "--virtual", "--json")
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stdout, "")
        self.assertIn("slave 2", result.stderr.splitlines()[-1])
        self.assertIn("1234", result.stderr.splitlines()[-1])
        self.assertEqual(self.files(), ["line.toml"])

    def test_output_that_nobody_can_write(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            result = self.run_program_to(full, "slaves", "--config", LINE8)
        self.assertEqual(result.returncode, 1)
        self.assertIn("cannot be written", result.stderr)

    def run_program_to(self, stdout, *arguments):
        return subprocess.run([DRIVELINE, *map(str, arguments)], cwd=self.directory, stdout=stdout,
                              stderr=subprocess.PIPE, text=True, timeout=PATIENCE_S, check=False)


class FirstDay(WireTest):
    """Mistakes of a first-time user."""

    def test_no_link_names_the_interface(self):
        self.addCleanup(subprocess.run, [*self.prefix, "ip", "link", "set", "dl-line", "up"], check=True)
        subprocess.run([*self.prefix, "ip", "link", "set", "dl-line", "down"], check=True)
        for command in (["slaves"], ["run", "--duration", "1"]):
            self.check_refused(self.run_program(*command, "--iface", "dl-master"), 1, "dl-master: no link", "cable")

    def test_an_interface_whose_frames_are_too_short_is_refused(self):
        self.addCleanup(subprocess.run, [*self.prefix, "ip", "link", "set", "dl-master", "mtu", "1500"], check=True)
        subprocess.run([*self.prefix, "ip", "link", "set", "dl-master", "mtu", "1400"], check=True)
        config = self.write("line.toml", '[realtime]\npolicy = "enforce"\n[[slave]]\nname = "x"\n')
        result = self.run_program("run", "--config", config, "--iface", "dl-master", "--duration", 0.1, "--no-telemetry")
        self.check_refused(result, 1, "dl-master: the interface takes no frames of more than 1400 bytes",
                           "ip link set dev dl-master mtu 1500")

    def test_nothing_to_exchange_is_remarked_on(self):
        config = self.write("line.toml", f'[line]\ncycle_us = 1000\n[[slave]]\nname = "x"\n'
                            f'esi = "{EXAMPLES / "terminals.xml"}"\ndevice = "BC100"\n')
        result = self.run_program("run", "--config", config, "--virtual", "--duration", 0.1, "--no-telemetry", "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("there are no process data: ", result.stderr)
        self.assertIn("driveline pdos", result.stderr)

    def test_a_slave_that_exchanges_nothing_is_named(self):
        config = self.write("line.toml", '[line]\ncycle_us = 1000\n[[slave]]\nname = "x"\n[[slave]]\nname = "idle"\n'
                            '[[axis]]\nname = "x"\n')
        result = self.run_program("run", "--config", config, "--virtual", "--duration", 0.1, "--no-telemetry",
                                  "--no-plots", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        sentence = "slave 1: exchanges no process data: of its 8 PDOs none with objects is assigned to a sync manager"
        self.assertIn(sentence, result.stderr)
        events = json.loads(result.stdout)["events"]
        self.assertEqual(len([event for event in events if sentence in event]), 1, events)
        self.assertFalse([event for event in events if "slave 0" in event], events)

    def test_a_folder_for_two_runs_is_refused(self):
        config = self.write_gentle_line(cycle_us=2000)
        first = self.start("run", "--config", config, "--no-plots", log="first.log")
        self.wait_for("OP", lambda: "all in OP" in self.text("first.log"), first)
        second = ["run", "--config", config, "--virtual", "--duration", 0.1, "--no-plots"]
        self.check_refused(self.run_program(*second), 1, "out: another run is writing into this folder", "--output")
        self.assertEqual(self.run_program(*second, "--output", "other").returncode, 0)
        self.assertEqual(self.end(first, signal.SIGTERM), 0, self.logs())
        self.assertEqual(self.run_program(*second).returncode, 0, "it is free again")

    def test_changes_to_a_line_that_ends_with_the_command(self):
        remark = "every command starts a new one"
        for change in (["states", "PREOP"], ["download", "-t", "int8", "0x6060", "0", "8"], ["sii", "alias", "-p", "2", "7"],
                       ["reg", "write", "-p", "0", "watchdog_divider", "2498"]):
            result = self.run_program(*change, "--config", LINE8)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertIn(remark, result.stderr, change)
        self.assertNotIn(remark, self.run_program("states", "--config", LINE8).stderr)

    def test_a_line_that_is_not_as_described_has_a_status_of_its_own(self):
        differs = self.write("line.toml", line_description().replace('name = "z"\n', 'name = "z"\nrevision = ">= 0xFFFFFFFF"\n', 1))
        self.assertEqual(self.run_program("scan", "--config", LINE8).returncode, 0)
        for arguments in ([], ["--json"]):
            self.assertEqual(self.run_program("scan", "--config", differs, *arguments).returncode, 3)
        self.assertEqual(self.run_program("scan", "--config", differs, "--write", "found.toml").returncode, 0)

    def test_benchmarks_that_are_not_there(self):
        for folder in (self.directory, self.directory / "none"):
            self.check_refused(self.run_program("bench", "--list", "--dir", folder), 2, str(folder), "cmake --build build")


class Hostile(ProgramTest):
    """Files and limits made to do harm."""

    @staticmethod
    def limit(what, size):
        return lambda: resource.setrlimit(what, (size, size))

    def test_files_that_never_end(self):
        # Sanitizers reserve terabytes of addresses.
        limit = {} if SANITIZED else {"preexec_fn": self.limit(resource.RLIMIT_AS, 2 << 30)}
        image = self.write("line.toml", '[[slave]]\nname = "x"\nsii = "/dev/zero"\n')
        path = self.write("path.toml", '[[slave]]\nname = "x"\n[[axis]]\nname = "x"\n[path]\nfile = "/dev/zero"\n')
        device = self.write("device.toml", '[[slave]]\nname = "x"\nesi = "/dev/zero"\n')
        for arguments, place in ((["slaves", "--config", "/dev/zero"], "/dev/zero"),
                                 (["slaves", "--config", device], "device.toml:3: [slave 1] esi: /dev/zero"),
                                 (["slaves", "--config", image], "line.toml:3: [slave 1] sii: /dev/zero"),
                                 (["esi", "validate", "/dev/zero"], "/dev/zero"),
                                 (["plan", "/dev/zero"], "/dev/zero"),
                                 (["run", "--config", path], "/dev/zero"),
                                 (["sii", "write", "--config", LINE8, "-p", "0", "/dev/zero"], "/dev/zero")):
            with self.subTest(arguments=arguments):
                self.check_refused(self.run_program(*arguments, **limit), 2, f"{place}: is larger than 128 MiB")

    def test_keys_that_go_too_deep(self):
        for text in (".".join(["a"] * 60_000) + " = 1\n", "[" + ".".join(["a"] * 60_000) + "]\n", "a = " + "[" * 60_000):
            with self.subTest(text=text[:10]):
                config = self.write("line.toml", text)
                self.check_refused(self.run_program("slaves", "--config", config), 2, "line.toml:1: ", "levels deep")

    def test_entries_of_no_bits(self):
        esi = (EXAMPLES / "terminals.xml").read_text(encoding="utf-8").replace("<BitLen>1<", "<BitLen>0<")
        self.write("zero.xml", esi)
        config = self.write("line.toml", '[[slave]]\nname = "x"\nesi = "zero.xml"\ndevice = "DI8"\n[[slave.input]]\n'
                            'entry = "Channel 1/Input"\nvalue = 1\n')
        self.check_refused(self.run_program("slaves", "--config", config), 2, "line.toml:6: [slave 1.input 1] entry: ",
                           "is no input of the device")

    def check_harmless(self, result):
        """Nothing in it is an order to a terminal, and what was one can be seen."""
        text = result.stdout + result.stderr
        orders = [c for c in text if (ord(c) < 0x20 and c not in "\n\t") or 0x7F <= ord(c) < 0xA0]
        self.assertEqual(orders, [], text)

    def test_orders_to_the_terminal(self):
        esi = (EXAMPLES / "terminals.xml").read_text(encoding="utf-8")
        esi = esi.replace(">DI8<", ">DI8&#27;[31m\u009b2J<").replace("Channel 1", "Channel&#27;]0;title&#7; 1")
        self.write("escape.xml", esi)
        config = self.write("line.toml", '[line]\nname = "l\\u001b[2J"\ncycle_us = 1000\n[[slave]]\nname = "x\\u009b31m"\n'
                            '[[axis]]\nname = "x"\nslave = "x\\u009b31m"\n[[slave]]\nname = "d\\u0007"\nesi = "escape.xml"\n'
                            'product_code = 0x108\n')
        run = ["run", "--config", config, "--virtual", "--duration", 0.1, "--no-telemetry"]
        for arguments in (run, [*run, "--json"], ["slaves", "--config", config, "-v"], ["scan", "--config", config],
                          ["pdos", "--config", config], ["pdos", "--config", config, "--json"],
                          ["cstruct", "--config", config], ["graph", "--config", config], ["diag", "--config", config],
                          ["sii", "read", "--config", config, "-p", 1, "-v"], ["esi", "show", "escape.xml"],
                          ["esi", "validate", "escape.xml"]):
            with self.subTest(arguments=arguments):
                result = self.run_program(*arguments)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.check_harmless(result)
        self.assertIn("\\x1B", self.run_program("esi", "show", "escape.xml").stdout)
        document = self.one_document(self.run_program("pdos", "--config", config, "--image", "--json").stdout)
        self.assertEqual(document["slaves"][0]["name"], "x\x9b31m", "as it is in the file")
        named = self.write("axis.toml", '[[slave]]\nname = "x"\n[[axis]]\nname = "x\\u009b31m"\nslave = "x"\n')
        self.check_harmless(self.run_program("run", "--config", named))
        for arguments in (["\x1b[31mwalk"], ["slaves", "--config", "no\x1b[2Jfile"], ["run", "--config", "x", "--\x07"]):
            result = self.run_program(*arguments)
            self.assertEqual(result.returncode, 2)
            self.check_harmless(result)

    def run_with_capture(self, *arguments, **options):
        result = self.run_program("run", "--config", LINE8, "--virtual", "--duration", 1, "--json", "--no-telemetry",
                                  "--no-plots", *arguments, **options)
        self.assertEqual(result.returncode, 1, result.stderr)
        return self.one_document(result.stdout), result.stderr.splitlines()[-1]

    def test_a_file_that_may_not_get_longer_leaves_the_summary(self):
        document, sentence = self.run_with_capture("--capture", "c.pcapng",
                                                   preexec_fn=self.limit(resource.RLIMIT_FSIZE, 64 << 10))
        self.assertEqual((document["cycles"], document["state"]), (8000, "OP"))
        self.assertIn("File too large", sentence)
        self.assertTrue(any("c.pcapng" in fault and "File too large" in fault for fault in document["faults"]), document)

    def test_a_full_disk_leaves_the_summary(self):
        (self.directory / "full").mkdir()
        made = "mount -t tmpfs -o size=200k none full"
        if subprocess.run(["unshare", "-m", "sh", "-c", made], cwd=self.directory, capture_output=True,
                          check=False).returncode != 0:
            self.skipTest("no file system of its own here")
        self.prefix = ["unshare", "-m", "sh", "-c", f'{made} && exec "$0" "$@"']
        document, sentence = self.run_with_capture("--capture", "full/c.pcapng")
        self.assertEqual((document["cycles"], document["state"], len(document["axes"])), (8000, "OP", 8))
        self.assertIn("full/c.pcapng", sentence)
        self.assertIn("No space left on device", sentence)

    def test_files_for_which_a_full_disk_had_no_room_are_a_failure(self):
        # It depends on the size what is the first that does not fit: CSV files, or one of the pictures.
        if shutil.which("gnuplot") is None:
            self.skipTest("pictures need gnuplot")
        (self.directory / "full").mkdir()
        first = set()
        for size in (4, 40, 64, 96, 128, 160, 200, 4000):
            made = f"mount -t tmpfs -o size={size}k none full"
            if subprocess.run(["unshare", "-m", "sh", "-c", made], cwd=self.directory, capture_output=True,
                              check=False).returncode != 0:
                self.skipTest("no file system of its own here")
            with self.subTest(size=size):
                # What is there when the run has ended goes with the file system.
                seen = f"seen{size}"
                (self.directory / seen).mkdir()
                keep = f'status=$?; for f in full/*; do [ -e "$f" ] && cp "$f" {seen}/; done; exit $status'
                self.prefix = ["unshare", "-m", "sh", "-c", f'{made} && "$0" "$@"; {keep}']
                result = self.run_program("run", "--config", LINE8, "--virtual", "--duration", "100ms", "--json",
                                          "--no-telemetry", "--output", "full")
                document = self.one_document(result.stdout)
                self.assertEqual((document["cycles"], document["state"]), (800, "OP"))
                pictures = [file for key, file in document["files"].items() if key.endswith("_plot")]
                for file in document["files"].values():
                    content = (self.directory / seen / pathlib.Path(file).name).read_bytes()
                    self.assertEqual(content[-8:] if file in pictures else b"IEND\xaeB`\x82", b"IEND\xaeB`\x82", file)
                self.assertEqual(result.returncode, 0 if len(pictures) == 3 else 1, result.stderr)
                if result.returncode == 1:
                    name = re.match(r"full/([a-z_]+\.[a-z]+): c(?:an|ould )not be written", document["faults"][0])
                    self.assertTrue(name, document["faults"])
                    first.add(name[1])
                    self.assertEqual(result.stderr.splitlines()[-1], f"driveline run: {document['faults'][0]}")
        self.assertIn("axes.csv", first)
        self.assertTrue(any(name.endswith(".png") for name in first), first)

    def test_too_little_stack(self):
        self.prefix = ["sh", "-c", 'ulimit -s 64 && exec "$0" "$@"']
        for command in (["run", "--config", LINE8, "--duration", 1], ["slaves", "--config", LINE8]):
            self.check_refused(self.run_program(*command), 1, "stack", "64 KiB", "ulimit -s")

    def test_a_signal_while_the_description_is_read(self):
        fifo = self.directory / "line.toml"
        os.mkfifo(fifo)
        for number in (signal.SIGHUP, signal.SIGTERM):
            with self.subTest(signal=number):
                # On virtual time: a run that a machine holds up for long before it stops must have enabled its axes.
                run = self.start("run", "--config", fifo, "--virtual", "--json", "--no-plots", "--no-telemetry", log="run.log")
                with open(fifo, "w", encoding="utf-8") as pipe:  # opens when the program does
                    run.send_signal(number)
                    pipe.write(line_description(cycle_us=1000))
                self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
                self.assertIn("stop requested: taking the line down", self.text("run.log"))
                document = self.one_document(self.text("run.log.out"))
                self.assertEqual((document["state"], document["faults"]), ("OP", []))

    def test_a_run_that_is_stopped_is_not_waited_for(self):
        run = self.start("run", "--config", self.write_gentle_line(cycle_us=1000), "--control", "run.socket", "--no-plots",
                         log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        run.send_signal(signal.SIGSTOP)
        self.check_refused(self.run_program("diag", "--control", "run.socket"), 1, "run.socket: no answer within",
                           f"(process {run.pid})")
        run.send_signal(signal.SIGCONT)


class Privileges(WireTest):
    def test_missing_ones_name_the_remedy(self):
        if os.geteuid() != 0:
            self.skipTest("only root can become somebody without privileges")
        program = self.directory / "driveline"  # readable by all users
        shutil.copy(DRIVELINE, program)
        program.chmod(0o755)
        for name in ("line8.toml", "line8.csv"):  # a checkout of root may be readable by nobody else
            shutil.copy(EXAMPLES / name, self.directory)
        before = self.files()
        line = self.directory / "line8.toml"
        self.prefix = [*self.prefix, "setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
        for arguments in (["slaves"], ["run", "--config", line], ["simulate", "--config", line]):
            with self.subTest(arguments=arguments):
                result = self.run_program(*arguments, "--iface", "dl-master", program=program)
                self.check_refused(result, 1, "CAP_NET_RAW", "setcap")
                self.assertEqual(self.files(), before)


if __name__ == "__main__":
    unittest.main()
