"""Lines of 1, 8 and 64 drives, a ring on two interfaces, and faults while the line is served."""
import signal
import subprocess
import unittest

from line_sizes import LineSizeTest
from program import DRIVELINE, PATIENCE_S, ProgramTest, RingTest, WireTest


class LineSize(LineSizeTest):
    def test_1_drive(self):
        self.accepted(1, 1000)

    def test_8_drives(self):
        self.accepted(8, 2000)

    def test_64_drives(self):
        self.accepted(64, 5000)


class FaultsWhileServed(WireTest):
    def start_controlled(self, config, *arguments):
        line = self.start("simulate", "--config", config, "--iface", "dl-line", "--control", "line.socket", *arguments,
                          log="line.log")
        self.wait_for("the simulated line", lambda: "slaves on dl-line" in self.text("line.log"), line)
        return line

    def fault(self, *words):
        return self.run_program("fault", "--control", "line.socket", *words)

    def states_of_slaves(self):
        result = self.run_program("slaves", "--iface", "dl-master", "--json")
        return [slave["serial_number"] for slave in self.one_document(result.stdout)["slaves"]]

    def config(self, count=4, head=""):
        names = "xyzabcuv"
        return self.write("line.toml", head + "".join(f'[[slave]]\nname = "{names[i]}"\n' for i in range(count)))

    def test_the_master_sees_what_is_commanded(self):
        line = self.start_controlled(self.config())
        self.assertEqual(self.states_of_slaves(), [1, 2, 3, 4])
        done = self.fault("cable-break", "slave=y", "to=z")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "done\n", ""))
        self.assertEqual(self.states_of_slaves(), [1, 2])
        self.assertEqual(self.fault("list").stdout, "cable-break slave=y port=1\n")
        self.assertEqual(self.fault("heal", "cable-break", "slave=z", "to=y").stdout, "done\n")
        self.assertEqual(self.states_of_slaves(), [1, 2, 3, 4])
        self.assertEqual(self.fault("power-off slave=1").returncode, 0)
        self.assertEqual(self.fault("states").stdout, "INIT: x z a; OFF: y\n")
        self.assertEqual(self.states_of_slaves(), [1])
        self.assertEqual(self.fault("heal", "all").returncode, 0)
        self.assertEqual(self.fault("list").stdout, "no faults\n")
        self.assertEqual(self.states_of_slaves(), [1, 2, 3, 4])
        log = self.text("line.log")
        self.assertIn("fault begins: cable-break slave=y port=1", log)
        self.assertIn("fault ends: cable-break slave=y port=1", log)
        self.assertIn("slave 1 (y): OFF", log)
        # The end of the line ends the socket, too.
        self.assertEqual(self.fault("quit").stdout, "ending\n")
        self.assertEqual(line.wait(PATIENCE_S), 0)
        self.assertNotIn("line.socket", self.files())
        self.check_refused(self.fault("list"), 1, "line.socket", "simulate --control")

    def test_commands_that_are_wrong(self):
        line = self.start_controlled(self.config())
        for words, parts in ((["dorp"], ["not a kind of fault", "drop"]), (["power-off", "slave=q"], ["\"q\""]),
                             (["heal", "drop"], ["this fault is not active"]), (["cable-break", "slave=a", "port=1"], ["port 1"]),
                             (["drop", "chance=2"], ["chance", "0 to 1"])):
            with self.subTest(words=words):
                self.check_refused(self.fault(*words), 1, *parts)
        self.check_refused(self.run_program("fault", "list"), 1, "no line runs", "--control PATH")
        self.check_refused(self.run_program("simulate", "--config", "line.toml", "--iface", "dl-line", "--control",
                                            "line.toml"), 1, "line.toml", "already")
        self.check_refused(self.run_program("simulate", "--config", "line.toml", "--iface", "dl-line", "--control",
                                            "line.socket"), 1, "line.socket", "already")
        self.check_refused(self.run_program("simulate", "--config", "line.toml", "--iface", "dl-line", "--iface2",
                                            "dl-master"), 2, "--iface2", "ring")
        self.assertEqual(self.end(line, signal.SIGTERM), 0)
        self.assertEqual(self.files(), ["line.log", "line.log.out", "line.toml"], "the socket is gone, no other file")

    def test_typed_commands(self):
        config = self.config()
        with open(self.directory / "line.log", "wb") as log:
            line = subprocess.Popen([*self.prefix, DRIVELINE, "simulate", "--config", str(config), "--iface", "dl-line"],
                                    cwd=self.directory, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log)
            self.addCleanup(self.kill, line)
            line.stdin.write(b"power-off slave=x\nlist\nheal all\nhelp\ndorp\nquit\n")
            out, _ = line.communicate(timeout=PATIENCE_S)
        self.assertEqual(line.returncode, 0, self.logs())
        self.assertIn(b"states: INIT INIT INIT INIT", out)
        log = self.text("line.log")
        for text in ("fault begins: power-off slave=x", "\npower-off slave=x\n", "fault ends: power-off slave=x",
                     "refuse-transition", "error: \"dorp\" is not a kind of fault"):
            self.assertIn(text, log)

    def test_inputs_are_set_and_read(self):
        switch = '[[slave]]\nname = "x"\n[[slave.switch]]\ninput = "ISD02"\nfrom_rev = -1\nto_rev = 1\n'
        config = self.write("line.toml", switch + '[[slave]]\nname = "y"\n')
        self.start_controlled(config)

        def command(*words):
            return self.run_program("input", "--control", "line.socket", *words)

        shown = command("x").stdout.splitlines()
        self.assertIn("input  ENPO = 1", shown)
        self.assertIn("input  ISD02 = 1", shown, "the shaft is on the cam")
        self.assertIn("input  DC_LINK = 560", shown)
        self.assertIn("output STO_RELAY = 0", shown)
        self.assertEqual(command("x", "ISDSH=0", "ISD02=0", "DC_LINK=48").stdout, "done\n")
        shown = command("0").stdout.splitlines()
        for line in ("input  ISDSH = 0", "input  ISD02 = 0", "input  DC_LINK = 48", "output STO_RELAY = 1"):
            self.assertIn(line, shown)
        self.assertIn("input  ISDSH = 1", command("y").stdout.splitlines(), "only the slave that was named")
        # The master sees it: 2079h, without ISDSH (bit 7).
        image = self.run_program("upload", "--iface", "dl-master", "-p", "0", "-t", "uint32", "0x2079", "0")
        self.assertEqual(image.stdout.split()[0], "0x00000001", image.stderr)
        for words, part in ((["q"], "no slave"), (["x", "ISD09=1"], "there are ENPO"), (["x", "ISD00=2"], "0 or 1"),
                            (["x", "ISD00"], "INPUT=VALUE"), (["x", "BRAKE=1"], "no input")):
            with self.subTest(words=words):
                self.check_refused(command(*words), 1, part)
        self.check_refused(self.run_program("input", "x"), 1, "no line runs", "--control PATH")

    def test_script_of_the_line_file(self):
        script = '[[fault]]\nat_ms = 200\nkind = "power-off"\nslave = "z"\nfor_ms = 300\n'
        line = self.start_controlled(self.config(head=script))
        self.wait_for("the fault ends", lambda: "fault ends: power-off slave=z" in self.text("line.log"), line)
        log = self.text("line.log")
        self.assertLess(log.index("fault begins: power-off slave=z"), log.index("fault ends"))
        self.assertIn("slave 2 (z): OFF", log)

    def test_end_of_stdin_is_no_end_of_the_line(self):
        line = self.start_controlled(self.config())  # stdin is /dev/null
        self.assertEqual(self.states_of_slaves(), [1, 2, 3, 4])
        self.assertIsNone(line.poll())


class Ring(RingTest):
    """Both ends of a ring on interfaces of their own; the other ends of the cables are in the hands of the test."""

    PROBE = r"""
import select, socket, sys
# BRD of AL status, 2 bytes, from each interface in turn; prints where it came back and with which working counter.
names = ["dl-master", "dl-master2"]
sockets = []
for name in names:
    s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4))
    s.bind((name, 0x88A4))
    sockets.append(s)
for number, s in enumerate(sockets):
    frame = bytes.fromhex("ffffffffffff 001020304050 88a4 0e10 07 00 0000 3001 0200 0000 0000 0000")
    frame = frame[:17] + bytes([number + 1]) + frame[18:]
    frame += bytes(60 - len(frame))
    answer = None
    for _ in range(50):
        s.send(frame)
        ready, _, _ = select.select(sockets, [], [], 0.2)
        for r in ready:
            reply, address = r.recvfrom(2000)
            if address[2] != socket.PACKET_OUTGOING and reply[17] == number + 1 and len(reply) == 60:
                answer = (names[sockets.index(r)], int.from_bytes(reply[28:30], "little"))
        if answer:
            break
    print(names[number], *(answer or ("nothing",)))
"""

    def probe(self):
        result = self.run_program("-c", self.PROBE, program="python3")
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout.splitlines()

    def test_frames_take_the_way_the_ring_leads_them(self):
        names = "xyzab"
        config = self.write("ring.toml", '[wiring]\npreset = "ring"\n' + "".join(f'[[slave]]\nname = "{n}"\n' for n in names))
        line = self.start("simulate", "--config", config, "--iface", "dl-line", "--iface2", "dl-line2", "--control",
                          "ring.socket", log="line.log")
        self.wait_for("the ring", lambda: "slaves on dl-line and dl-line2" in self.text("line.log"), line)
        self.assertEqual(self.probe(), ["dl-master dl-master2 5", "dl-master2 dl-master 0"])
        broken = self.run_program("fault", "--control", "ring.socket", "cable-break", "slave=y", "to=z")
        self.assertEqual(broken.returncode, 0, broken.stderr)
        self.assertEqual(self.probe(), ["dl-master dl-master 2", "dl-master2 dl-master2 3"])
        self.run_program("fault", "--control", "ring.socket", "heal", "all")
        self.assertEqual(self.probe(), ["dl-master dl-master2 5", "dl-master2 dl-master 0"])
        self.assertEqual(self.end(line, signal.SIGTERM), 0)

    def test_without_the_second_interface_it_is_a_line(self):
        config = self.write("ring.toml", '[wiring]\npreset = "ring"\n' + "".join(f'[[slave]]\nname = "{n}"\n' for n in "xyz"))
        line = self.start("simulate", "--config", config, "--iface", "dl-line", log="line.log")
        self.wait_for("the line", lambda: "slaves on dl-line" in self.text("line.log"), line)
        found = self.one_document(self.run_program("slaves", "--iface", "dl-master", "--json").stdout)["slaves"]
        self.assertEqual(len(found), 3)


class Eeprom(WireTest):
    # BWR to 0x0502: write command, word address 0x000E (serial number, low word), value 0x1234 (ETG.1000.4 6.4).
    WRITE = r"""
import socket, time
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4))
s.bind(("dl-master", 0x88A4))
frame = bytes.fromhex("ffffffffffff 001020304050 88a4 1410 08 00 0000 0205 0800 0000 0102 0e000000 3412 0000")
for _ in range(5):
    s.send(frame + bytes(60 - len(frame)))
    time.sleep(0.05)
"""

    def serial_number(self):
        found = self.one_document(self.run_program("slaves", "--iface", "dl-master", "--json").stdout)
        return found["slaves"][0]["serial_number"]

    def test_what_a_master_writes_is_there_at_the_next_start(self):
        config = self.write("line.toml", '[[slave]]\nname = "x"\nsii_file = "x.sii"\n')
        line = self.start_line(config)
        self.assertEqual(self.serial_number(), 1)
        self.assertEqual(self.run_program("-c", self.WRITE, program="python3").returncode, 0)
        self.assertEqual(self.serial_number(), 0x1234)
        self.end_line(line)
        self.assertEqual((self.directory / "x.sii").read_bytes()[0x1C:0x1E], b"\x34\x12")
        line = self.start_line(config)
        self.assertEqual(self.serial_number(), 0x1234)
        before = (self.directory / "x.sii").stat().st_mtime_ns
        self.end_line(line)
        self.assertEqual((self.directory / "x.sii").stat().st_mtime_ns, before, "nothing has changed")
        (self.directory / "x.sii").write_bytes(b"")
        self.check_refused(self.run_program("slaves", "--config", config), 2, "line.toml:3: [slave 1] sii_file",
                           "x.sii")


class InProcess(ProgramTest):
    def test_wiring_and_faults_of_the_line_in_this_process(self):
        text = ('[wiring]\npreset = "branch"\njunction = "x"\nbranch_slaves = 1\n'
                '[[slave]]\nname = "x"\n[[slave]]\nname = "y"\n[[slave]]\nname = "z"\n')
        found = self.one_document(self.run_program("slaves", "--config", self.write("line.toml", text), "--json").stdout)
        self.assertEqual(len(found["slaves"]), 3)
        off = self.write("off.toml", text + '[[fault]]\nkind = "power-off"\nslave = "y"\n')
        found = self.one_document(self.run_program("slaves", "--config", off, "--json").stdout)
        self.assertEqual([slave["serial_number"] for slave in found["slaves"]], [1, 3], "the branch is gone")


if __name__ == "__main__":
    unittest.main()
