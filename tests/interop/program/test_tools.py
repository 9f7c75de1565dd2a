"""The bus tools: what they print in process, and EEPROMs that keep what was written, over the wire."""
import os
import re
import signal
import subprocess
import sys
import unittest

from program import ATTEMPTS, DISTURBED, DRIVELINE, EXAMPLES, PATIENCE_S, ROOT, ProgramTest, WireTest, again_when, again_when_disturbed

LINE8 = EXAMPLES / "line8.toml"
ESI_FILE = ROOT / "esi/data/moog_msd.xml"
# BRD of AL status, every 2 ms, from an address that no master of this program uses.
FOREIGN_MASTER = r"""
import socket, time
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0)
s.bind(("dl-master", 0))
frame = bytes.fromhex("ffffffffffff 00005e000001 88a4 0e10 07 00 0000 3001 0200 0000 0000 0000") + bytes(30)
while True:
    s.send(frame)
    print("sent", flush=True)
    time.sleep(0.0002)  # a tool is done with its look in a few ms
"""
# Claims an interface as a process of this program does.
LOCK_HOLDER = r"""
import socket, time
s = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
s.bind(f"\0driveline/interface/{socket.if_nametoindex('dl-master')}")
print("begins", flush=True)
time.sleep(3600)
"""
# Another master: leaves the first slave with the counter in argv[1] as that of the last mail, and no answer behind. A
# mail with the counter of the one before is dropped, so of these two the second is always taken.
LEAVE_COUNTER = r"""
import socket, struct, sys
wire = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4))
wire.bind(("dl-master", 0))
wire.settimeout(30)

def access(command, address, data):
    body = struct.pack("<BBHHHH", command, 0x5A, 0x1001, address, len(data), 0) + data + bytes(2)
    wire.send(b"\xff" * 6 + bytes.fromhex("000000000001 88a4") + struct.pack("<H", 0x1000 | len(body)) + body)
    while True:
        frame = wire.recv(2000)
        if frame[6] & 2 and frame[17] == 0x5A:
            return frame[26 + len(data)]

last = int(sys.argv[1])
for counter in ((last + 5) % 7 + 1, last):
    upload = bytes.fromhex("0020 40 0010 00 00000000")
    mail = struct.pack("<HHBB", len(upload), 0, 0, 3 | counter << 4) + upload
    assert access(5, 0x1000, mail.ljust(512, b"\0")) == 1, "not taken"
    silent = 0
    while silent < 50:
        silent = 0 if access(4, 0x1200, bytes(512)) else silent + 1
"""


class InProcess(ProgramTest):
    def tool(self, *arguments, status=0):
        result = self.run_program(*arguments, "--config", LINE8)
        self.assertEqual(result.returncode, status, result.stderr)
        return result.stdout

    def test_slaves(self):
        lines = self.tool("slaves").splitlines()
        self.assertEqual(len(lines), 8)
        for position, line in enumerate(lines):
            self.assertRegex(line, rf"\A{position}  0:{position}  INIT  \+  MSD\b")
        self.assertEqual(self.tool("slaves", "-p", "2,4-5").splitlines(), [lines[2], lines[4], lines[5]])

    def test_slaves_in_detail(self):
        text = self.tool("slaves", "-p", "1", "-v")
        for part in ("=== Master 0, Slave 1 ===", "  Vendor Id:       0x00000028", "  Serial number:   0x00000002",
                     "   0  MII   up    open    yes", "   2  N/A   down  closed  no", "  Supported protocols: EoE, CoE, FoE",
                     "SM2: PhysAddr 0x1400", "FMMU0: outputs"):
            self.assertIn(part, text)
        document = self.one_document(self.tool("slaves", "--json"))
        slave = document["slaves"][7]
        self.assertEqual((slave["position"], slave["serial_number"], slave["state"]), (7, 8, "INIT"))
        self.assertEqual([port["link"] for port in slave["controller"]["ports"]], [True, False, False, False])
        self.assertEqual(slave["sii"]["mailbox"]["protocols"], ["EoE", "CoE", "FoE"])

    def test_values_as_pattern_and_number(self):
        self.assertEqual(self.tool("upload", "-p", "0", "-t", "int32", "0x6064", "0"), "0x00000000 0\n")
        self.assertEqual(self.tool("upload", "-p", "0", "-t", "uint16", "0x6041", "0"), "0x0250 592\n")
        self.assertEqual(self.tool("upload", "-p", "0", "-t", "raw", "0x6041", "0"), "0x50 0x02\n")
        # Without a type, the one that the slave's dictionary names.
        self.assertEqual(self.tool("upload", "-p", "0", "0x6041", "0"), "0x0250 592\n")
        self.assertEqual(self.tool("upload", "-p", "0", "0x1008", "0"), "MSD Servo Drive\n")
        self.assertEqual(self.tool("download", "-p", "0", "0x6060", "0", "8"), "")
        result = self.run_program("download", "-p", "0", "--config", LINE8, "0x6060", "0", "300")
        self.check_refused(result, 2, "300", "int8")
        self.assertEqual(self.tool("download", "-p", "0", "-t", "int32", "0x607A", "0", "-5"), "")

    def test_registers(self):
        self.assertEqual(self.tool("reg", "read", "-p", "3", "al_status"), "0x0001 1\n")
        self.assertEqual(self.tool("reg_read", "-p", "3", "0x0130", "2"), "0x01 0x00\n")
        self.assertEqual(self.tool("reg_read", "-p", "3", "0x0130", "-t", "uint16"), "0x0001 1\n")
        self.assertEqual(self.tool("reg_read", "-p", "0,7", "station address"), "   0  0x1001 4097\n   7  0x1008 4104\n")
        self.assertEqual(self.tool("reg_write", "-p", "0", "-t", "uint16", "0x0400", "1000"), "")
        document = self.one_document(self.tool("reg", "read", "-p", "2-3", "type", "--json"))
        self.assertEqual(document, {"address": 0, "bytes": 1, "name": "type",
                                    "slaves": [{"position": 2, "value": 0x11}, {"position": 3, "value": 0x11}]})

    def test_register_misuse(self):
        for status, arguments, parts in (
                (2, ["reg", "read", "0x9000"], ["0x9000", "--type"]),
                (2, ["reg", "read", "colour"], ["colour", "reg list"]),
                (2, ["reg", "read", "-t", "uint8", "0x0130", "2"], ["size 2", "uint8"]),
                (2, ["reg", "write", "watchdog_divider", "1"], ["the line has 8 slaves", "-p N"]),
                (1, ["reg", "write", "-p", "0", "al_status", "2"], ["slave 0", "AL status", "read-only"]),
                (1, ["reg", "read", "-p", "8", "al_status"], ["no slave 8"]),
                (1, ["slaves", "-a", "17"], ["alias address 17"]),
                (2, ["slaves", "-p", "3-1"], ["3-1"]),
                (1, ["pdos", "-p", "9"], ["no slave 9"])):
            with self.subTest(arguments=arguments):
                self.check_refused(self.run_program(*arguments, "--config", LINE8), status, *parts)

    def test_pdos_of_eeprom_and_slave(self):
        for arguments in (["--sii"], []):
            text = self.tool("pdos", "-p", "0", *arguments)
            self.assertRegex(text, r"(?m)^SM2: PhysAddr 0x1400, DefaultSize +\d+, ControlRegister 0x64, Enable 1$")
            self.assertRegex(text, r'(?m)^  RxPDO 0x1600 "')
            self.assertRegex(text, r'(?m)^  TxPDO 0x1a00 "')
        self.assertEqual(self.tool("pdos").count("=== Master 0, Slave "), 8)
        document = self.one_document(self.tool("pdos", "-p", "0", "--json"))
        self.assertEqual(document["slaves"][0]["source"], "coe")
        self.assertEqual([channel["direction"] for channel in document["slaves"][0]["sync_managers"]],
                         ["outputs", "inputs", "outputs", "inputs"])

    def test_declarations_compile(self):
        self.write("pdos.cpp", self.tool("cstruct", "-p", "0-1") +
                   "\nint main() { return kSlave0Pdos.outputs.size() == kSlave1Pdos.outputs.size() ? 0 : 1; }\n")
        includes = [f"-I{ROOT / 'ecat_master/motion/include'}"]  # the room of the PDOs, and nothing that it uses
        document = self.one_document(self.tool("cstruct", "-p", "0-1", "--json"))
        self.assertIn(document["include"], (self.directory / "pdos.cpp").read_text())
        for slave in document["slaves"]:
            self.assertIn(slave["declaration"], (self.directory / "pdos.cpp").read_text())
            self.assertEqual(slave["source"], "coe")
        result = subprocess.run([os.environ["CXX_COMPILER"], "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror",
                                 *includes, "pdos.cpp"], cwd=self.directory, capture_output=True, text=True,
                                timeout=PATIENCE_S, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_eeprom_image_and_what_it_says(self):
        self.assertEqual(self.tool("sii", "read", "-p", "1", "-o", "drive.sii"), "")
        image = (self.directory / "drive.sii").read_bytes()
        self.assertEqual(int.from_bytes(image[0x10:0x14], "little"), 0x28)
        self.assertEqual(int.from_bytes(image[0x1C:0x20], "little"), 2)
        piped = subprocess.run([*self.prefix, os.environ["DRIVELINE"], "sii_read", "-p", "1", "--config", LINE8],
                               capture_output=True, timeout=PATIENCE_S, check=True).stdout
        self.assertEqual(piped, image)
        text = self.tool("sii", "read", "-p", "1", "-v")
        self.assertIn("checksum valid", text)
        # The bytes stand behind what they say, every one of them once.
        lines = re.findall(r"(?m)^  ([0-9a-f]{4}) ((?: [0-9a-f]{2})+) ", text)
        self.assertEqual(bytes.fromhex("".join(digits for _, digits in lines)), image)
        self.assertEqual(int(lines[-1][0], 16) + len(bytes.fromhex(lines[-1][1])), len(image))
        self.assertRegex(text, r"(?m)^Word 0x0040: category 10 \(strings\), \d+ words$")
        self.assertIn("  Product code:    0x4d534431", text)
        self.assertEqual(self.one_document(self.tool("sii", "read", "-p", "1", "--json"))["serial_number"], 2)

    def test_eeprom_against_the_device_file(self):
        self.assertIn("matches ", self.tool("sii", "compare", "-p", "5", ESI_FILE))
        changed = re.sub(r"(<Name[^>]*><!\[CDATA\[|<Name[^>]*>)MSD Servo", r"\1MSD Other", ESI_FILE.read_text())
        other = self.write("other.xml", changed)
        self.assertNotEqual(changed, ESI_FILE.read_text())
        result = self.run_program("sii", "compare", "-p", "5", "--config", LINE8, other)
        self.assertEqual(result.returncode, 1)
        self.assertIn("name: ", result.stdout)
        self.assertIn("slave 5: 1 difference from", result.stderr)
        revision = self.write("revision.xml", re.sub(r'RevisionNo="[^"]*"', 'RevisionNo="#x1"', ESI_FILE.read_text()))
        self.check_refused(self.run_program("sii", "compare", "--config", LINE8, revision), 1, "has no device",
                           "revision 0x007C001E")

    def test_images_that_do_not_fit_are_refused(self):
        self.tool("sii", "read", "-p", "0", "-o", "drive.sii")
        good = (self.directory / "drive.sii").read_bytes()
        write = ["sii", "write", "-p", "0", "--config", LINE8]
        broken = bytearray(good)
        broken[2] ^= 1
        (self.directory / "checksum.sii").write_bytes(broken)
        self.check_refused(self.run_program(*write, "checksum.sii"), 1, "checksum.sii", "checksum", "--force")
        other = bytearray(good)
        other[0x14] ^= 1
        (self.directory / "other.sii").write_bytes(other)
        self.check_refused(self.run_program(*write, "other.sii"), 1, "product", "--force")
        (self.directory / "short.sii").write_bytes(good[:100])
        self.check_refused(self.run_program(*write, "short.sii"), 2, "short.sii")
        self.check_refused(self.run_program(*write, "none.sii"), 2, "none.sii")
        self.check_refused(self.run_program("sii", "write", "--config", LINE8, "drive.sii"), 2, "the line has 8 slaves")
        self.assertEqual(self.run_program(*write, "--force", "other.sii").returncode, 0)

    def test_objects(self):
        text = self.tool("sdos", "-p", "0", "0x6041")
        self.assertRegex(text, r'\ASDO 0x6041, "[^"]+"\n  0x6041:00, r-r-r-, uint16, 16 bit, "[^"]+"\n\Z')
        names = self.tool("sdos", "-p", "0", "-q").splitlines()
        self.assertGreater(len(names), 20)
        self.assertTrue(all(re.fullmatch(r'SDO 0x[0-9a-f]{4}, ".*"', name) for name in names))
        objects = self.one_document(self.tool("sdos", "-p", "0", "0x1018", "--json"))["slaves"][0]["objects"]
        self.assertEqual([entry["subindex"] for entry in objects[0]["entries"]], [0, 1, 2, 3, 4])
        self.assertEqual(self.tool("sdos", "0x1000").count("=== Master 0, Slave "), 8)
        self.check_refused(self.run_program("sdos", "--config", LINE8, "-p", "0", "0x5FFF"), 1, "slave 0", "5FFF")

    def test_graph(self):
        dot = self.tool("graph")
        self.assertTrue(dot.startswith("digraph"))
        drawn = subprocess.run(["dot", "-Tsvg"], input=dot, capture_output=True, text=True, timeout=PATIENCE_S,
                               check=False)
        self.assertEqual(drawn.returncode, 0, drawn.stderr)
        self.assertEqual(len(re.findall(r"s\d -> s\d", dot)), 7)
        self.assertEqual(len(self.tool("graph", "--tree").splitlines()), 9)
        document = self.one_document(self.tool("graph", "--json"))
        self.assertIsNone(document["slaves"][0]["parent"])
        self.assertEqual(document["slaves"][7]["parent"], {"slave": 6, "port": 1})

    def test_description_of_what_was_found_runs_unchanged(self):
        table = self.tool("scan").splitlines()
        self.assertEqual(len(table), 9)
        self.assertLessEqual(max(map(len, table)), 80, table)
        self.assertTrue(table[1].endswith(" MSD Servo Drive (si..."), table)
        self.tool("scan", "--write", "line.toml")
        result = self.run_program("run", "--config", "line.toml", "--virtual", "--duration", 0.2, "--json", "--no-plots",
                                  "--no-telemetry")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual((document["state"], document["faults"]), ("OP", []))
        # Nothing moves, but the drives are axes, scaled as they say.
        self.assertIn("\nincrements_per_revolution = 1048576", (self.directory / "line.toml").read_text())
        self.assertEqual(document["axes_count"], 8)
        self.assertIn("hold their positions", result.stderr)
        # It expects what was found: another device is noticed.
        text = (self.directory / "line.toml").read_text(encoding="utf-8")
        self.write("other.toml", text.replace("product_code = 0x4D534431", "product_code = 0x4D534432", 1))
        result = self.run_program("run", "--config", "other.toml", "--virtual", "--duration", 0.2, "--no-plots")
        self.assertEqual(result.returncode, 1)
        self.assertIn("4D534432", result.stderr)

    def test_description_of_devices_of_all_kinds_runs_unchanged(self):
        scan = self.run_program("scan", "--config", EXAMPLES / "mixed.toml", "--write", "again.toml")
        self.assertEqual(scan.returncode, 0, scan.stderr)
        result = self.run_program("run", "--config", "again.toml", "--virtual", "--duration", 0.2, "--json", "--no-plots",
                                  "--no-telemetry")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(self.one_document(result.stdout)["state"], "OP")
        again = self.run_program("scan", "--config", "again.toml")
        self.assertEqual(again.stdout, scan.stdout)

    def test_alias_of_a_simulated_line_is_in_its_description(self):
        self.tool("sii", "read", "-p", "1", "-o", "image.sii")
        image = bytearray((self.directory / "image.sii").read_bytes())
        image[8:10] = (77).to_bytes(2, "little")
        crc = 0xFF
        for byte in image[:14]:
            crc ^= byte
            for _ in range(8):
                crc = (crc << 1 ^ 0x07) & 0xFF if crc & 0x80 else crc << 1
        image[14] = crc
        (self.directory / "alias.sii").write_bytes(image)
        self.write("one.toml", '[line]\nname = "one"\ncycle_us = 1000\n[[slave]]\nname = "x"\nsii_file = "alias.sii"\n')
        scan = self.run_program("scan", "--config", "one.toml", "--write", "found.toml")
        self.assertEqual(scan.returncode, 0, scan.stderr)
        self.assertIn("\nalias = 77\n", (self.directory / "found.toml").read_text())
        result = self.run_program("run", "--config", "found.toml", "--virtual", "--duration", 0.2, "--no-plots",
                                  "--no-telemetry")
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_states_of_single_slaves(self):
        self.assertEqual(self.tool("states", "-p", "1-2,5", "PREOP"), "   1  PREOP\n   2  PREOP\n   5  PREOP\n")
        self.assertEqual(len(self.tool("states").splitlines()), 8)
        for status, arguments, parts in (
                (2, ["BOOT"], ["single slaves", "-p N"]),
                (2, ["-p", "1", "op"], ["cyclic process data", "`run`", "--iface"]),
                (1, ["-a", "9"], ["alias address 9"])):
            with self.subTest(arguments=arguments):
                self.check_refused(self.run_program("states", "--config", LINE8, *arguments), status, *parts)

    def test_boot_is_for_slaves_that_have_it(self):
        self.assertEqual(self.tool("states", "-p", "1", "BOOT"), "   1  BOOT\n")
        result = self.run_program("states", "--config", EXAMPLES / "mixed.toml", "-p", "0", "BOOT")
        self.check_refused(result, 1, "slave 0: has no mailbox for BOOT: its EEPROM defines none for the bootstrap state")

    def test_files_of_a_drive(self):
        file = self.directory / "set.txt"
        document = self.one_document(self.tool("foe", "read", "-p", "1", "parameters.txt", "-o", file, "--json"))
        self.assertEqual((document["name"], document["bytes"]), ("parameters.txt", file.stat().st_size))
        self.assertIn("6065:00 = ", file.read_text())
        self.assertEqual(self.tool("foe_read", "-p", "1", "parameters.txt"), file.read_text())
        self.tool("foe", "write", "-p", "1", "-o", "parameters.txt", file)
        file.write_text("7777:00 = 1\n")
        for status, arguments, parts in (
                (1, ["write", "-o", "parameters.txt", file],
                 ["slave 0: refused the file with FoE error 0x8004 (illegal): line 1: there is no such object"]),
                (1, ["read", "x", "-o", file], ["0x8001 (not found)"]),
                (2, ["write", self.directory / "none"], ["none: cannot be read"]),
                (2, ["write", "--boot", file], ["single slaves", "-p N"]),
                (2, ["read", "x", "--password", "0x1FFFFFFFF"], ["password"]),
                (2, ["read", "parameters.txt", "--json"], ["--output FILE"])):
            with self.subTest(arguments=arguments):
                self.check_refused(self.run_program("foe", *arguments, "--config", LINE8), status, *parts)
        self.assertEqual(file.read_text(), "7777:00 = 1\n", "what could not be read leaves the file alone")

    def test_files_behind_a_password(self):
        config = self.write("line.toml", '[line]\ncycle_us = 1000\n[[slave]]\nname = "x"\nfile_password = 0xDEADBEEF\n')
        read = lambda *password: self.run_program("foe", "read", "--config", config, "parameters.txt", "-o", "set.txt", *password)
        for wrong in ([], ["--password", "0xDEADBEEE"], ["--password", "0xBEEF"]):
            with self.subTest(wrong=wrong):
                self.check_refused(read(*wrong), 1, "slave 0: refused the file with FoE error 0x800A", "wrong password")
                self.assertFalse((self.directory / "set.txt").exists())
        right = read("--password", "0xDEADBEEF")
        self.assertEqual(right.returncode, 0, right.stderr)
        self.assertIn("6065:00 = ", (self.directory / "set.txt").read_text())

    def test_firmware_goes_through_boot(self):
        self.assertEqual(self.run_program("esi", "generate", "devices").returncode, 0)
        firmware = self.directory / "devices" / "moog_msd.efw"
        document = self.one_document(self.tool("foe_write", "-p", "2", "--boot", firmware, "--json"))
        self.assertEqual((document["name"], document["bytes"]), ("moog_msd.efw", firmware.stat().st_size))
        result = self.run_program("foe", "write", "--config", LINE8, "-p", "2", firmware)
        self.check_refused(result, 1, "slave 2: refused the file with FoE error 0x8008 (in bootstrap only)")
        other = self.directory / "devices" / "servoone.efw"
        result = self.run_program("foe", "write", "--config", LINE8, "-p", "2", "--boot", other)
        self.check_refused(result, 1, "0x800D (firmware does not fit the hardware): the firmware is for another drive")

    def test_operation_data_of_drives(self):
        line = ["--config", EXAMPLES / "soe.toml", "-p", "1", "--drive", "1"]
        text = self.run_program("soe", "list", *line).stdout
        self.assertEqual(len(text.splitlines()), 10)
        self.assertRegex(text, r"(?m)^S-0-0100  Velocity loop proportional gain +100")
        document = self.one_document(self.run_program("soe_read", "S-0-0001", *line, "--json").stdout)
        self.assertEqual([document[key] for key in ("slave", "drive", "idn", "name", "value", "unit", "minimum", "default", "state")],
                         [1, 1, "S-0-0001", "NC cycle time (TNcyc)", 1000, "us", 125, 1000, None])
        self.assertEqual(document["attribute"]["protected"], ["SAFEOP", "OP"])
        listed = self.one_document(self.run_program("soe", "list", *line, "--json").stdout)["idns"]
        self.assertIn({key: document[key] for key in document if key not in ("slave", "drive")}, listed)
        for arguments in (["S-0-0100", "150"], ["100", "0x2C"], ["s-0-142", "x" * 512], ["S-0-0142", ""]):
            with self.subTest(arguments=arguments):
                result = self.run_program("soe", "write", *arguments, *line)
                self.assertEqual((result.returncode, result.stdout), (0, ""), result.stderr)
        result = self.run_program("soe_write", "S-0-0099", "--execute", *line)
        self.assertEqual((result.returncode, result.stdout), (0, ""), result.stderr)
        self.assertRegex(result.stderr, r"slave 1 drive 1: data state of S-0-0099 is 0x0003 \(executed\)")
        for status, arguments, parts in (
                (2, ["read", "S-0-4096"], ['IDN "S-0-4096": S-0-0017, P-0-0017 or a number is expected']),
                (2, ["read", "0x10000"], ['IDN "0x10000"']),
                (2, ["read", "S-0-0001", "--drive", "8"], ["drive"]),
                (2, ["write", "S-0-0100"], ["VALUE", "--execute"]),
                (2, ["write", "S-0-0099", "3", "--execute"], ["VALUE", "--execute"]),
                (2, ["write", "S-0-0100", "70000"], ['"70000" is not a value of 2 bytes, unsigned']),
                (2, ["write", "S-0-0100", "1,2"], ['"1,2" is not a value of 2 bytes, unsigned']),
                (1, ["read", "P-0-0001"], ["slave 1: refused P-0-0001 of drive 1 with SoE error 0x1001 (there is no such IDN)"]),
                (1, ["list", "--drive", "2"], ["S-0-0017 of drive 2 with SoE error 0x800A (there is no such drive)"]),
                (1, ["write", "S-0-0011", "0"], ["0x7004 (the value cannot be changed)"]),
                (1, ["write", "S-0-0100", "0"], ["0x7006 (value below its minimum)"]),
                (1, ["write", "S-0-0100", "10001"], ["0x7007 (value above its maximum)"]),
                (1, ["write", "S-0-0142", "x" * 513], ["0x7003 (value too long)"]),
                (1, ["write", "S-0-0100", "--execute"], ["S-0-0100 is not a procedure command"])):
            with self.subTest(arguments=arguments):
                self.check_refused(self.run_program("soe", arguments[0], *line[:4], *line[4:] * ("--drive" not in arguments),
                                                    *arguments[1:]), status, *parts)
        self.check_refused(self.run_program("soe", "list", "--config", LINE8), 1,
                           "slave 0: answered with mailbox error 0x0002 (unsupported protocol)")

    def test_single_slaves_go_up_to_safeop(self):
        self.assertEqual(self.tool("states", "-p", "1,3", "safeop"), "   1  SAFEOP\n   3  SAFEOP\n")
        states = [slave["state"] for slave in self.one_document(self.tool("states", "-p", "0-3", "--json"))["slaves"]]
        self.assertEqual(states, ["INIT"] * 4, "each command has a line of its own")

    def test_objects_of_a_mixed_line(self):
        result = self.run_program("sdos", "-q", "--config", EXAMPLES / "mixed.toml")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, r"(?m)^left out: slave 0 has no CoE mailbox$")
        self.assertIn("SDO 0x6041", result.stdout, "the drives are listed")
        self.check_refused(self.run_program("sdos", "-q", "-p", "0", "--config", EXAMPLES / "mixed.toml"), 1,
                           "slave 0 has no mailbox")

    def test_diagnosis(self):
        self.assertIn("no problem is known", self.tool("diag"))
        document = self.one_document(self.tool("diag", "--json"))
        self.assertEqual(document["places"], [])
        self.assertEqual([slave["answers"] for slave in document["slaves"]], [True] * 8)
        self.assertEqual(document["slaves"][0]["name"], "x")

    def test_rescan(self):
        self.assertEqual(self.tool("rescan"), "8 slaves, all in INIT\n")


class OnTheWire(WireTest):
    def tool(self, *arguments, status=0):
        result = self.run_program(*arguments, "--iface", "dl-master")
        self.assertEqual(result.returncode, status, result.stderr)
        return result.stdout

    def test_a_full_disk_keeps_the_old_file(self):
        (self.directory / "full").mkdir()
        script = 'mount -t tmpfs -o size=4k none full && echo old > full/set.txt && "$@"; echo "status $?: $(cat full/set.txt)"; ls full'
        result = self.run_program("-m", "sh", "-c", script, "sh", DRIVELINE, "foe", "read", "--config", LINE8, "-p", "1",
                                  "parameters.txt", "-o", "full/set.txt", program="unshare")
        self.assertEqual(result.stdout, "status 1: old\nset.txt\n", result.stderr)
        self.assertRegex(result.stderr, r"^driveline[^\n]*full/set\.txt[^\n]*No space left on device\n$")

    def test_looking_changes_nothing(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        self.tool("states", "PREOP")
        for arguments in (["slaves"], ["slaves", "-v"], ["pdos", "--sii"], ["reg", "read", "al_status"],
                          ["sii", "read", "-v", "-p", "0"]):
            self.tool(*arguments)
        states = self.one_document(self.tool("states", "--json"))["slaves"]
        self.assertEqual({slave["state"] for slave in states}, {"PREOP"})
        self.assertRegex(self.tool("slaves").splitlines()[0], r"\A0  0:0  PREOP  \+  MSD")

    def test_single_slaves_change_their_state_and_the_others_stay(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        self.tool("states", "SAFEOP")
        self.tool("states", "-p", "2", "PREOP")
        self.assertEqual(self.tool("upload", "-p", "4", "-t", "uint16", "0x6041", "0"), "0x0250 592\n")
        self.tool("states", "-p", "7", "INIT")
        self.assertEqual(self.tool("upload", "-p", "7", "-t", "uint16", "0x6041", "0"), "0x0250 592\n")
        states = [slave["state"] for slave in self.one_document(self.tool("states", "--json"))["slaves"]]
        # Where there is a mailbox nothing changes; from INIT it is opened in PREOP.
        self.assertEqual(states, ["SAFEOP", "SAFEOP", "PREOP", "SAFEOP", "SAFEOP", "SAFEOP", "SAFEOP", "PREOP"])

    @again_when_disturbed
    def test_line_that_a_master_drives_is_not_disturbed(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        master = self.start("run", "--config", self.write_gentle_line(cycle_us=1000), "--iface", "dl-master", "--no-plots",
                            "--no-telemetry", "--json", log="master.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("master.log"), master)
        # Through the mailbox, in OP.
        self.assertRegex(self.tool("upload", "-p", "3", "-t", "uint16", "0x6041", "0"), r"\A0x[0-9a-f]{2}37 \d+\n\Z")
        self.tool("download", "-p", "3", "-t", "uint32", "0x6083", "0", "104857601")
        self.assertEqual(self.tool("upload", "-p", "3", "-t", "uint32", "0x6083", "0"), "0x06400001 104857601\n")
        self.assertIn("SDO 0x6041", self.tool("sdos", "-p", "5", "0x6041"))
        self.assertIn("RxPDO 0x1600", self.tool("pdos", "-p", "2"))
        self.tool("scan", "--write", "found.toml")
        self.assertEqual(self.text("found.toml").count("\n[[axis]]\n"), 8)
        # What would take it out of operation is refused.
        for arguments in (["states", "PREOP"], ["states", "-p", "2", "INIT"], ["rescan"], ["dc", "--duration", "1"],
                          ["pdos", "--image", "--config", EXAMPLES / "line8-nic.toml"]):
            result = self.run_program(*arguments, "--iface", "dl-master")
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertEqual(result.stdout, "")
            for part in ("is in OP: a master drives", "--force"):
                self.assertIn(part, result.stderr, arguments)
        states = self.one_document(self.tool("states", "--json"))["slaves"]
        self.assertEqual({slave["state"] for slave in states}, {"OP"})
        self.assertIsNone(master.poll(), self.text("master.log"))
        self.tool("states", "-p", "7", "INIT", "--force")
        self.wait_for("the master notices", lambda: "slave 7" in self.text("master.log"))

    OTHER_MASTER = "another EtherCAT master is on the wire"

    def start_foreign_master(self):
        return self.start_noise(FOREIGN_MASTER, log="foreign.log")

    def test_tools_are_heard_behind_whatever_mail_another_master_has_sent(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        self.tool("states", "PREOP")
        for counter in range(1, 8):
            with self.subTest(counter=counter):
                left = self.run_program("-c", LEAVE_COUNTER, counter, program=sys.executable)
                self.assertEqual(left.returncode, 0, left.stderr)
                self.tool("foe", "read", "-p", "0", "parameters.txt", "-o", "set.txt")

    @again_when_disturbed
    def test_another_master_on_the_wire_is_named(self):
        config = self.write_gentle_line(cycle_us=2000)
        self.start_line(config)
        foreign = self.start_foreign_master()
        result = self.run_beside_noise("foreign.log", "sii", "read", "-v", "--iface", "dl-master", tells=self.OTHER_MASTER)
        self.assertIn(self.OTHER_MASTER, result.stderr)
        self.assertIn("02:00:5E:00:00:01", result.stderr)
        master = self.start_master(config, "--no-telemetry")
        self.wait_for("the master names it", lambda: self.OTHER_MASTER in self.text("master.log"), master)
        self.assertIsNone(foreign.poll())
        self.assertEqual(self.end(master, signal.SIGTERM), 0, self.logs())

    @again_when_disturbed
    def test_tools_beside_a_run_are_no_other_master(self):
        config = self.write_gentle_line(cycle_us=2000)
        self.start_line(config)
        master = self.start_master(config, "--no-telemetry")
        for arguments in (["states"], ["slaves", "-v"], ["sii", "read", "-p", "1", "-v"], ["diag"],
                          ["upload", "-p", "3", "-t", "uint16", "0x6041", "0"], ["drive", "-p", "1", "--once"],
                          ["download", "-p", "3", "-t", "uint32", "0x6083", "0", "104857601"]):
            result = self.run_program(*arguments, "--iface", "dl-master")
            self.assertEqual(result.returncode, 0, f"{arguments}: {result.stderr}")
            self.assertNotIn(self.OTHER_MASTER, result.stderr, arguments)
        self.assertEqual(self.end(master, signal.SIGTERM), 0, self.logs())
        self.assertNotIn(self.OTHER_MASTER, self.text("master.log"))
        self.assertNotIn("not ours", self.text("master.log"))
        self.assertEqual(self.one_document(self.text("master.log.out"))["faults"], [])

    @again_when_disturbed
    def test_a_second_run_does_not_take_the_line_away(self):
        config = self.write_gentle_line(cycle_us=2000)
        self.start_line(config)
        master = self.start_master(config, "--no-telemetry")
        second = ["run", "--config", config, "--iface", "dl-master", "--no-plots", "--no-telemetry", "--duration", 0.2,
                  "--output", "second"]
        for _ in range(3):
            self.check_refused(self.run_program(*second), 1, f"process {master.pid} (driveline run) uses interface dl-master",
                               "interrupt its line", "--force")
        self.check_refused(self.run_program("simulate", "--config", config, "--iface", "dl-master"), 1,
                           f"process {master.pid} (driveline run)", "--force")
        self.assertNotIn("axis", self.text("master.log").partition("following the path")[2])
        self.assertIsNone(master.poll(), self.logs())
        forced = self.run_program(*second, "--force")
        self.assertIn("slaves found", forced.stderr, "whoever insists gets it")
        self.wait_for("the first one to lose it", lambda: master.poll() is not None)
        self.assertEqual(master.returncode, 1, self.logs())

    def test_a_second_simulated_line_does_not_answer_as_well(self):
        line = self.start_line(EXAMPLES / "line8-nic.toml")
        self.check_refused(self.run_program("simulate", "--config", EXAMPLES / "line8-nic.toml", "--iface", "dl-line"), 1,
                           f"process {line.pid} (driveline simulate) uses interface dl-line", "answer there as well")

    def test_tools_that_write_leave_a_line_alone_that_is_being_started(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        holder = self.start("-c", LOCK_HOLDER, program=sys.executable, log="holder.log")
        self.wait_for("the lock", lambda: "begins" in self.text("holder.log.out"), holder)
        for arguments in (["states", "PREOP"], ["states", "-p", "2", "PREOP"], ["rescan"], ["upload", "-p", "1", "0x1008", "0"],
                          ["alias", "-p", "1", "9"], ["reg_write", "-p", "1", "-t", "uint16", "0x0420", "9"],
                          ["dc", "--duration", "1", "--config", EXAMPLES / "line8-nic.toml"],
                          ["pdos", "--image", "--config", EXAMPLES / "line8-nic.toml"],
                          ["run", "--duration", "1", "--no-plots"]):
            with self.subTest(arguments=arguments):
                result = self.run_program(*arguments, "--iface", "dl-master")
                self.assertEqual((result.returncode, result.stdout), (1, ""), result.stderr)
                self.assertRegex(result.stderr, rf"process {holder.pid} \(python.* uses interface dl-master; this command would .*; "
                                                "--force does it anyway\n$")
        self.assertIn("Serial number", self.tool("slaves", "-v"), "looking is allowed")
        self.assertEqual(self.tool("states", "-p", "2", "PREOP", "--force"), "   2  PREOP\n")
        holder.kill()
        holder.wait(PATIENCE_S)
        self.assertEqual(self.tool("states", "-p", "3", "PREOP"), "   3  PREOP\n")

    @again_when(*DISTURBED)
    def test_a_line_in_op_is_taken_over_from_the_dead_and_not_from_the_living(self):
        config = self.write_gentle_line(cycle_us=2000)
        self.start_line(config)
        for _ in range(ATTEMPTS):
            master = self.start_master(config, "--no-telemetry")
            master.kill()
            master.wait(PATIENCE_S)
            # While its watchdog has not run out: from now on there is none.
            self.tool("reg_write", "--force", "-p", "0", "-t", "uint16", "0x0420", "0")
            if self.tool("states", "-p", "0") == "   0  OP\n":
                break
        again = ["run", "--config", config, "--iface", "dl-master", "--no-plots", "--no-telemetry", "--duration", 0.2]
        foreign = self.start_foreign_master()
        refused = self.run_program(*again)
        self.assertEqual(refused.returncode, 1, refused.stderr)
        self.assertRegex(refused.stderr, rf"slave 0 is in OP and {self.OTHER_MASTER}: .*this run would interrupt the other master; --force")
        self.assertEqual(self.tool("states", "-p", "0"), "   0  OP\n", "nothing has been written")
        foreign.kill()
        foreign.wait(PATIENCE_S)
        result = self.run_program(*again)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("slave 0 is in OP, but no frame of another master arrived for 150 ms: this run takes over the line", result.stderr)

    def test_diagnosis_names_the_bad_cable_until_it_is_cleared(self):
        self.start("simulate", "--config", EXAMPLES / "line8-nic.toml", "--iface", "dl-line", "--control", "line.socket",
                   log="line.log")
        self.wait_for("the simulated line", lambda: "slaves on dl-line" in self.text("line.log"))
        fault = self.run_program("fault", "--control", "line.socket", "damage", "slave=z", "port=0", "count=3")
        self.assertEqual(fault.returncode, 0, fault.stderr)
        self.tool("states", "--json")
        place = self.one_document(self.tool("diag", "--json"))["places"][0]
        self.assertEqual((place["kind"], place["slave"], place["port"], place["other"]), ("damaged_frames", 2, 0, 1))
        self.assertIn(place["sentence"], self.tool("diag", "--clear"))
        self.assertIn("no problem is known", self.tool("diag"))

    def test_description_of_what_was_found_runs_unchanged(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        self.tool("scan", "--write", "line.toml")
        result = self.run_undisturbed("run", "--config", "line.toml", "--duration", 0.5, "--json", "--no-plots", "--no-telemetry")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(self.one_document(result.stdout)["state"], "OP")
        # Two slaves that have changed places, or another one, are noticed: they have serial numbers.
        text = (self.directory / "line.toml").read_text(encoding="utf-8")
        swapped = text.replace("serial = 3\n", "serial = -\n").replace("serial = 4\n", "serial = 3\n")
        for name, changed, said in (("swapped.toml", swapped.replace("serial = -\n", "serial = 4\n"),
                                     "slave 2 and slave 3 have changed places"),
                                    ("other.toml", text.replace("serial = 2\n", "serial = 33\n"),
                                     "slave 1: serial number is 0x00000002 but 0x00000021 is planned")):
            with self.subTest(said=said):
                self.write(name, changed)
                result = self.run_program("run", "--config", name, "--iface", "dl-master", "--duration", 0.2, "--no-plots")
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertIn(said, result.stderr)

    def test_alias_and_image_stay_in_the_eeprom(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        self.assertIn("2 words changed", self.tool("alias", "-p", "3", "4711"))
        self.tool("sii", "read", "-p", "3", "-o", "drive.sii")
        image = bytearray((self.directory / "drive.sii").read_bytes())
        self.assertEqual(int.from_bytes(image[8:10], "little"), 4711)
        image[0x1C] = 0x77  # serial number
        (self.directory / "new.sii").write_bytes(image)
        document = self.one_document(self.tool("sii", "write", "-p", "3", "new.sii", "--json"))
        self.assertEqual((document["slave"], document["words_changed"]), (3, 1))
        self.tool("sii", "read", "-p", "3", "-o", "back.sii")
        self.assertEqual((self.directory / "back.sii").read_bytes(), bytes(image))

    @again_when_disturbed
    def test_neither_eeprom_nor_registers_change_under_a_master(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        master = self.start_master(self.write_gentle_line(cycle_us=1000), "--no-telemetry")
        for command, deed in ((["alias", "-p", "1", "9"], "write its EEPROM"),
                              (["reg_write", "-p", "1", "-t", "uint16", "0x0420", "9"], "change its registers")):
            result = self.run_program(*command, "--iface", "dl-master")
            self.assertEqual((result.returncode, result.stdout), (1, ""), result.stderr)
            self.assertIn(f"slave 1 is in OP: a master drives it, and this would {deed}; --force", result.stderr)
        self.assertEqual(self.tool("reg", "read", "-p", "1", "alias").split()[-1], "0")
        self.tool("reg_write", "--force", "-p", "1", "-t", "uint16", "0x0410", "1000")
        self.assertIsNone(master.poll(), self.logs())

    def test_single_slave_to_safeop_beside_the_others(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        self.tool("states", "PREOP")
        self.assertEqual(self.tool("states", "-p", "3", "SAFEOP"), "   3  SAFEOP\n")
        states = [slave["state"] for slave in self.one_document(self.tool("states", "--json"))["slaves"]]
        self.assertEqual(states, ["PREOP"] * 3 + ["SAFEOP"] + ["PREOP"] * 4)

    def test_names_of_process_data(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        # The drives have no mapping until one is written.
        self.tool("states", "SAFEOP", "--config", EXAMPLES / "line8-nic.toml")
        self.assertIn('PDO entry 0x6040:00, 16 bit, "Controlword"', self.tool("pdos", "-p", "0"))
        self.assertIn("{0x6041, 0x00, 16},  // Statusword", self.tool("cstruct", "-p", "0"))

    @again_when_disturbed
    def test_a_line_without_description_exchanges_process_data(self):
        self.start_line(EXAMPLES / "mixed.toml")
        arguments = ["run", "--iface", "dl-master", "--duration", 0.5, "--no-plots"]
        result = self.run_program(*arguments, "--json")
        self.write("run.log", result.stderr)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, "(?m)^no description: process data as assigned by the slaves, outputs zero, no axes$")
        document = self.one_document(result.stdout)
        self.assertEqual((document["state"], document["axes_count"]), ("OP", 0))
        self.assertGreaterEqual(document["process_data"]["groups"][0]["slaves"], 4)
        self.assertGreater(document["process_data"]["groups"][0]["exchanges"], 100)
        inputs = {row["name"]: row for row in document["inputs"]}
        self.assertTrue(any(name.startswith("slave1.") for name in inputs), inputs)
        self.assertTrue(all(row["value"] is not None for row in inputs.values()), inputs)
        self.assertIn("inputs at the end", self.run_program(*arguments).stdout)

    def test_complete_access(self):
        self.start_line(EXAMPLES / "mixed.toml")
        whole = self.tool("upload", "--complete", "-p", "3", "0x1018", "0").split()
        self.assertEqual(len(whole), 18, "number, a byte to fill up, four times 32 bit (ETG.1000.6 5.6.2)")
        vendor = self.tool("upload", "-p", "3", "-t", "uint32", "0x1018", "1").split()[0]
        self.assertEqual(int.from_bytes(bytes(int(byte, 16) for byte in whole[2:6]), "little"), int(vendor, 16))
        refused = self.run_program("upload", "--complete", "-p", "5", "0x1018", "0", "--iface", "dl-master")
        self.check_refused(refused, 1, "slave 5: object 1018h:00 aborted with 0x06010004")
        self.check_refused(self.run_program("upload", "--complete", "0x1018", "2", "--iface", "dl-master"), 2,
                           "--complete begins at 0 or 1")

    def test_eeprom_is_not_written_under_a_running_drive(self):
        self.start_line(EXAMPLES / "line8-nic.toml")
        self.tool("sii", "read", "-p", "0", "-o", "drive.sii")
        self.tool("states", "SAFEOP")
        result = self.run_program("sii", "write", "-p", "0", "drive.sii", "--iface", "dl-master")
        self.check_refused(result, 1, "slave 0 is in SAFEOP", "states INIT", "--force")


if __name__ == "__main__":
    unittest.main()
