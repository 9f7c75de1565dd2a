"""What is wrong with a line, as the tools say it: one sentence that names the slave."""
import re
import sys
import unittest

from program import AXES, EXAMPLES, ProgramTest, WireTest

CONFIG_AREA = 14  # bytes under the checksum, which is the next word
ALIAS = slice(8, 10)
FIRST_CATEGORY = 0x80

# Frames of EtherType 0x88A4 that no EtherCAT master has built; a line of output for each.
NOISE = """
import socket, time
port = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
port.bind(("dl-line", 0))
while True:
    port.send(bytes.fromhex("ffffffffffff020000000001" "88a4") + bytes(46))
    print("sent", flush=True)
    time.sleep(0.0001)
"""


def checksum(area):
    """CRC-8, x^8 + x^2 + x + 1, initial value 0xFF (ETG.1000.6 5.4)."""
    crc = 0xFF
    for byte in area:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x07) & 0xFF if crc & 0x80 else crc << 1
    return crc


class OfTheLine(ProgramTest):
    def line(self, tail="", slaves=("", "", "")):
        tables = "".join(f'[[slave]]\nname = "{name}"\n{keys}\n' for name, keys in zip("abc", slaves))
        return self.write("line.toml", f'[line]\nname = "l"\ncycle_us = 1000\n{tables}{tail}')

    def image(self, name, alias=0, good_checksum=True, categories=True):
        if not (self.directory / "generated").exists():
            self.run_program("esi", "generate", "generated")
        content = bytearray((self.directory / "generated/moog_msd.sii").read_bytes())
        content[ALIAS] = alias.to_bytes(2, "little")
        content[CONFIG_AREA] = checksum(content[:CONFIG_AREA]) ^ (0 if good_checksum else 0x55)
        if not categories:
            content[FIRST_CATEGORY:] = b"\xff" * (len(content) - FIRST_CATEGORY)
        (self.directory / name).write_bytes(content)
        return f'sii_file = "{name}"'

    def says(self, sentence, *command):
        """The command fails, and this is its last word."""
        result = self.run_program(*command, "--config", "line.toml")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr.splitlines()[-1], sentence)

    def run_says(self, sentence):
        result = self.run_program("run", "--config", "line.toml", "--virtual", "--duration", 0.1, "--no-plots",
                                  "--no-telemetry")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr.splitlines()[-1], sentence)

    def test_in_and_out_swapped(self):
        self.line('[wiring]\npreset = "custom"\n[[wiring.cable]]\nfrom = "master"\nto = "a:0"\n'
                  '[[wiring.cable]]\nfrom = "a:1"\nto = "b:0"\n[[wiring.cable]]\nfrom = "b:1"\nto = "c:1"\n')
        self.run_says(r"slave 2: IN and OUT are swapped, frames come in at port 1\Z")

    def test_duplicate_alias(self):
        self.line(slaves=("alias = 77\n" + self.image("a.sii", alias=77), "", self.image("c.sii", alias=77)))
        self.run_says(r"slave 0 and slave 2 both answer to alias 77; the first of 2 differences\Z")

    def test_duplicate_alias_that_nobody_plans(self):
        self.line(slaves=(self.image("a.sii", alias=77), "", self.image("c.sii", alias=77)))
        sentence = "alias 77: slaves 0 and 2 have it, it does not identify any of them"
        for command in (["slaves"], ["scan"], ["rescan"]):
            self.assertIn(sentence, self.run_program(*command, "--config", "line.toml").stderr.splitlines())
        self.assertIn("  " + sentence, self.run_program("diag", "--config", "line.toml").stdout.splitlines())
        document = self.one_document(self.run_program("scan", "--json", "--config", "line.toml").stdout)
        self.assertEqual(document["duplicate_aliases"], [{"alias": 77, "slaves": [0, 2]}])
        run = self.run_program("run", "--config", "line.toml", "--virtual", "--duration", 0.1, "--no-plots",
                               "--no-telemetry")
        self.assertEqual(run.returncode, 0, "it is in nobody's way")
        self.assertIn(sentence, run.stderr.splitlines())

    def test_wrong_checksum(self):
        self.line(slaves=("", self.image("b.sii", good_checksum=False), ""))
        self.everything_says(1, r"EEPROM checksum is 0x[0-9A-F]{2}, 0x[0-9A-F]{2} is expected: the slave ignores the content")
        details = self.run_program("sii", "read", "-p", "1", "-v", "--config", "line.toml")
        self.assertIn("checksum WRONG", details.stdout)
        self.assertRegex(details.stderr, r"(?m)^slave 1: EEPROM checksum is 0x")
        written = self.run_program("scan", "--write", "found.toml", "--config", "line.toml")
        self.assertEqual(written.returncode, 0, written.stderr)
        self.assertRegex(written.stderr, r"(?m)^slave 1: EEPROM checksum is 0x")
        self.assertRegex(self.text("found.toml"), r"(?m)^# slave 1: EEPROM checksum is 0x")

    def test_blank_eeprom(self):
        (self.directory / "b.sii").write_bytes(b"\xff" * 2048)
        self.line(slaves=("", 'sii_file = "b.sii"', ""))
        self.everything_says(1, "EEPROM is blank: all bytes are 0xFF")

    def test_categories_that_lead_nowhere(self):
        image = self.image("b.sii")
        content = bytearray((self.directory / "b.sii").read_bytes())
        content[FIRST_CATEGORY + 2:FIRST_CATEGORY + 4] = b"\x7f\x7f"
        (self.directory / "b.sii").write_bytes(content)
        self.line(slaves=("", image, ""))
        self.everything_says(1, r"EEPROM content is not usable at word 0x0044")

    def everything_says(self, slave, sentence):
        """Every command that meets the slave says what is wrong with its EEPROM, and nothing else of it."""
        line = f"slave {slave}: {sentence}"
        self.run_says(rf"driveline run: {line}\Z")
        for command in (["upload", "-p", slave, "0x6041", "0"], ["states", "PREOP"], ["states", "SAFEOP"]):
            self.says(rf"{line}\Z", *command)
        table = self.run_program("slaves", "--config", "line.toml").stdout.splitlines()
        self.assertEqual(len(table), 3, "the others are found")
        self.assertRegex(table[slave], rf"{line}\Z")
        self.assertIn("MSD", table[2])
        scan = self.run_program("scan", "--config", "line.toml").stdout.splitlines()
        self.assertRegex(scan[1 + slave], rf"{line}\Z")
        diag = self.run_program("diag", "--config", "line.toml").stdout
        self.assertRegex(diag, rf"(?m)\Awrong\n  {line}$")
        document = self.one_document(self.run_program("diag", "--json", "--config", "line.toml").stdout)
        self.assertRegex(document["problems"][0], rf"\A{line}\Z")
        self.assertEqual([(row["kind"], row["slave"], row["name"]) for row in document["differences"]],
                         [("eeprom", slave, "b")])
        objects = self.run_program("sdos", "-q", "--config", "line.toml")
        self.assertRegex(objects.stderr, rf"(?m)^left out: {line}$")
        self.assertEqual(objects.stdout.count("=== Master 0, Slave "), 2)

    def test_missing_categories(self):
        self.line(slaves=("", "", self.image("c.sii", categories=False)))
        self.says(r"slave 2: requested PREOP, is in INIT \+ error, AL status code 0x0016 \(invalid mailbox configuration",
                  "upload", "-p", "2", "0x6041", "0")
        value = self.run_program("upload", "--config", "line.toml", "-p", "1", "-t", "uint16", "0x6041", "0")
        self.assertEqual(value.returncode, 0, value.stderr)

    def test_silent_mailbox(self):
        self.line('[[fault]]\nkind = "mailbox-silent"\nslave = "b"\n')
        self.says(r"slave 1: no mailbox reply for object 6041h:00 within \d+ ms\Z", "upload", "-p", "1", "0x6041", "0")

    def test_aborted_transfer(self):
        self.line()
        self.says(r"slave 1: object 5FFFh:00 aborted with 0x06020000 \(object does not exist in the object dictionary\)\Z",
                  "upload", "-p", "1", "0x5FFF", "0")

    def test_late_and_lost_frames_cost_nothing(self):
        self.line('[[fault]]\nkind = "drop"\nway = "back"\nchance = 0.1\nseed = 3\n'
                  '[[fault]]\nkind = "delay"\ntime_us = 1500\nchance = 0.1\nseed = 4\n')
        value = self.run_program("upload", "--config", "line.toml", "-p", "1", "-t", "uint16", "0x6041", "0")
        self.assertEqual((value.returncode, value.stdout), (0, "0x0250 592\n"), value.stderr)

    def test_refused_state(self):
        self.line('[[fault]]\nkind = "refuse-transition"\nslave = "c"\nstate = "SAFEOP"\ncode = 0x1d\n')
        self.says(r"slave 2: requested SAFEOP, is in PREOP \+ error, AL status code 0x001D \(", "states", "SAFEOP")

    def test_changed_identity(self):
        self.line(slaves=("", "revision = 1", ""))
        self.run_says(r"slave 1: revision is 0x[0-9A-F]{8} but 0x00000001 is planned\Z")

    def test_eeprom_that_stays_busy(self):
        self.line('[[fault]]\nkind = "eeprom-busy"\nslave = "b"\ntime_us = 60000000\n')
        result = self.run_program("slaves", "--config", "line.toml")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stdout.splitlines()[1], r"slave 1: EEPROM interface stays busy at word 0x0000")
        self.assertIn("MSD", result.stdout.splitlines()[2])
        self.run_says(r"driveline run: slave 1: EEPROM interface stays busy at word 0x0000\Z")
        self.assertRegex(self.run_program("diag", "--config", "line.toml").stdout,
                         r"\Awrong\n  slave 1: EEPROM interface stays busy at word 0x0000\n")
        self.says(r"slave 1: EEPROM interface stays busy at word 0x00", "sii", "alias", "-p", "1", "5")

    def test_lost_frames_of_a_line_without_process_data(self):
        self.line('[[fault]]\nat_ms = 30\nkind = "damage"\nslave = "b"\nport = 0\ncount = 20\n')
        run = self.run_program("run", "--config", "line.toml", "--virtual", "--duration", 0.1, "--no-plots",
                               "--no-telemetry")
        self.assertRegex(run.stdout, r"(?m)^  lost frames +[1-9]\d*$")
        self.assertRegex(run.stdout, r"(?m)^    group line +every cycle, no process data$")
        self.assertNotIn("0 frames lost", run.stdout)

    def test_every_difference_is_told(self):
        self.line(slaves=("", 'revision = 1', 'revision = ">= 0xFFFFFFFF"'))
        run = self.run_program("run", "--config", "line.toml", "--virtual", "--duration", 0.1, "--no-plots",
                               "--no-telemetry")
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, r'(?m)^  slave 1: wrong revision: "b" \(slave 1: .* revision 0x00000001\) is planned, '
                                     r"found .* revision 0x007C001E serial 2$")
        self.assertRegex(run.stderr, r'(?m)^  slave 2: wrong revision: "c" \(slave 2: .* revision >= 0xFFFFFFFF\) is planned')
        self.assertRegex(run.stderr.splitlines()[-1], r"slave 1: revision is 0x007C001E but 0x00000001 is planned; "
                                                      r"the first of 2 differences\Z")
        for command in ("scan", "slaves"):
            told = self.run_program(command, "--config", "line.toml").stderr
            self.assertEqual(len(re.findall(r"(?m)^slave [12]: wrong revision: ", told)), 2, told)
        document = self.one_document(self.run_program("scan", "--json", "--config", "line.toml").stdout)
        self.assertEqual([(row["kind"], row["slave"], row["name"]) for row in document["differences"]],
                         [("revision", 1, "b"), ("revision", 2, "c")])

    def test_cable_broken_at_the_start(self):
        self.line('[[fault]]\nkind = "cable-break"\nslave = "a"\nto = "b"\n')
        self.run_says(r"planned slave 1 is not on the line; 1 slave answers, 3 are planned; the first of 2 differences\Z")
        problems = self.one_document(self.run_program("diag", "--json", "--config", "line.toml").stdout)["problems"]
        self.assertEqual(len(problems), 2)
        for problem, name in zip(problems, ('"b" (slave 1', '"c" (slave 2')):
            self.assertTrue(problem.startswith(f"missing: {name}"), problem)
            self.assertIn("behind slave 0", problem)


class OfTheWire(WireTest):
    def test_line_against_the_description_of_another(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        names = AXES
        serials = lambda these: "".join(f'[[slave]]\nname = "{name}"\nserial = {serial}\n' for name, serial in these)
        all_of_them = [(name, 1 + i) for i, name in enumerate(names)]
        head = '[line]\nname = "l"\ncycle_us = 1000\n'
        extra, missing = self.write("extra.toml", head + serials(all_of_them[:2] + all_of_them[3:])), self.write(
            "missing.toml", head + serials(all_of_them[:5] + [("new", 99)] + all_of_them[5:]))
        for command in ("run", "scan", "slaves", "diag"):
            for file, sentence in ((extra, r"extra: slave 2 is not planned: .*serial 3"),
                                   (missing, r'missing: "new" \(slave 5: .* serial 99\), behind slave 4')):
                with self.subTest(command=command, file=file.name):
                    result = self.run_program(command, "--config", file, "--iface", "dl-master")
                    self.assertEqual(result.returncode, {"run": 1, "scan": 3}.get(command, 0), result.stderr)
                    where = result.stdout if command == "diag" else result.stderr
                    self.assertRegex(where, rf"(?m)^(  )?{sentence}$")
        self.assertRegex(result.stdout, r"(?m)^ +6 \(" + names[6], "the names follow the slaves")

    def test_foreign_frames_are_told_and_cost_nothing(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        noise = self.start_noise(NOISE, log="noise.log")
        result = self.run_beside_noise("noise.log", "sii", "read", "-v", "-p", "3", "--iface", "dl-master", tells="frames of unknown origin")
        self.assertIn("Device name", result.stdout, result.stderr)
        self.assertIsNone(noise.poll())
        self.assertTrue(re.search(r"(?m)^\d+ frames of unknown origin were received: another master or other devices use the wire$",
                                  result.stderr), result.stderr)


if __name__ == "__main__":
    unittest.main()
