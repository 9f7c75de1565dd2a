"""What is wrong with a line, as the tools say it: one sentence that names the slave."""
import re
import sys
import unittest

from program import EXAMPLES, ROOT, ProgramTest, WireTest

IMAGE = ROOT / "esi/data/moog_msd.sii"
CONFIG_AREA = 14  # bytes under the checksum, which is the next word
ALIAS = slice(8, 10)
FIRST_CATEGORY = 0x80

# Frames of EtherType 0x88A4 that no EtherCAT master has built.
NOISE = """
import socket, time
port = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
port.bind(("dl-line", 0))
print("begins", flush=True)
while True:
    port.send(bytes.fromhex("ffffffffffff020000000001" "88a4") + bytes(46))
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
        content = bytearray(IMAGE.read_bytes())
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
        self.run_says(r"slave 0 and slave 2 both answer to alias or device ID 77\Z")

    def test_wrong_checksum(self):
        self.line(slaves=("", self.image("b.sii", good_checksum=False), ""))
        table = self.run_program("slaves", "--config", "line.toml")
        self.assertEqual(table.returncode, 0, table.stderr)
        self.assertEqual(len(table.stdout.splitlines()), 3, "the others are found")
        details = self.run_program("sii", "read", "-p", "1", "-v", "--config", "line.toml")
        self.assertIn("checksum WRONG", details.stdout)
        self.assertIn("slave 1: EEPROM: the checksum of the configuration area is wrong", details.stderr)

    def test_missing_categories(self):
        self.line(slaves=("", "", self.image("c.sii", categories=False)))
        self.says(r"slave 2: asked for PREOP, is in INIT, AL status code 0x0016 \(invalid mailbox configuration",
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
        self.says(r"slave 2: asked for SAFEOP, is in PREOP, AL status code 0x001D \(", "states", "SAFEOP")

    def test_changed_identity(self):
        self.line(slaves=("", "revision = 1", ""))
        self.run_says(r"slave 1: revision is 0x[0-9A-F]{8} but 0x00000001 is planned\Z")

    def test_eeprom_that_stays_busy(self):
        self.line('[[fault]]\nkind = "eeprom-busy"\nslave = "b"\ntime_us = 60000000\n')
        result = self.run_program("slaves", "--config", "line.toml")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stdout.splitlines()[1], r"slave 1: EEPROM interface stays busy at word 0x0000")
        self.assertIn("MSD", result.stdout.splitlines()[2])


class OfTheWire(WireTest):
    def test_foreign_frames_are_told_and_cost_nothing(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        noise = self.start("-c", NOISE, program=sys.executable, log="noise.log")
        self.wait_for("the noise", lambda: "begins" in self.text("noise.log.out"), noise)
        result = self.run_program("sii", "read", "-v", "-p", "3", "--iface", "dl-master")
        self.assertIn("Device name", result.stdout, result.stderr)
        self.assertIsNone(noise.poll())
        self.assertTrue(re.search(r"(?m)^\d+ frames that are not ours have come in: another master or other devices use the wire$",
                                  result.stderr), result.stderr)


if __name__ == "__main__":
    unittest.main()
