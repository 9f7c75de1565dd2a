"""A CANopen drive on python-can that lies: can_device.py '{"interface": "slcan", "channel": ...}' NODE LIE. With the lie "none" it
is a good drive of CiA 402 in interpolated position mode, which is with each SYNC where it was told to be. At the end of its
input it prints one JSON document with what it has seen. Run by test_can_liars.py with an interpreter that has python-can."""
import json
import select
import struct
import sys
import time

import can

PRE_OPERATIONAL, OPERATIONAL, STOPPED = 0x7F, 0x05, 0x04
SWITCH_ON_DISABLED, READY, SWITCHED_ON, ENABLED, QUICK_STOP = 0x40, 0x21, 0x23, 0x27, 0x07
ALWAYS, IN_MOTION = 0x0210, 0x1000  # of 6041h: voltage and remote; interpolated position is active
COMMANDS = {1: OPERATIONAL, 2: STOPPED, 0x80: PRE_OPERATIONAL}
LATE_S = 0.3  # more than the test lets an answer take

OBJECTS = {  # (index, sub-index): (value, bytes); text as bytes
    (0x1000, 0): (0x00020192, 4), (0x1001, 0): (0, 1), (0x1005, 0): (0x80, 4), (0x1006, 0): (0, 4),
    (0x1008, 0): b"a drive of python-can", (0x1014, 0): (0x80, 4), (0x1016, 0): (1, 1), (0x1016, 1): (0, 4), (0x1017, 0): (0, 2),
    (0x1018, 0): (4, 1), (0x1018, 1): (0x555, 4), (0x1018, 2): (0x402, 4), (0x1018, 3): (0x10003, 4), (0x1018, 4): (4711, 4),
    (0x2001, 0): b"as it comes from the factory",
    (0x603F, 0): (0, 2), (0x6040, 0): (0, 2), (0x6041, 0): (0x250, 2), (0x605A, 0): (2, 2), (0x6060, 0): (7, 1), (0x6061, 0): (7, 1),
    (0x6064, 0): (0, 4), (0x608F, 0): (2, 1), (0x608F, 1): (65536, 4), (0x608F, 2): (1, 4), (0x60C1, 0): (1, 1),
    (0x60C1, 1): (0, 4), (0x60C2, 0): (2, 1), (0x60C2, 1): (1, 1), (0x60C2, 2): (-3, 1), (0x6502, 0): (0x40, 4)}
for first in (0x1400, 0x1800):
    for number in range(2):
        base = (0x200 if first == 0x1400 else 0x180) + 0x100 * number
        OBJECTS |= {(first + number, 0): (5, 1), (first + number, 1): (base, 4), (first + number, 2): (255, 1),
                    (first + number, 3): (0, 2), (first + number, 5): (0, 2), (first + number + 0x200, 0): (0, 1)}
        OBJECTS |= {(first + number + 0x200, sub): (0, 4) for sub in range(1, 9)}


def next_state(state, word):
    """The state machine of CiA 402-2, as far as a master sees it."""
    if not word & 2:
        return SWITCH_ON_DISABLED
    if not word & 4:
        return QUICK_STOP if state in (ENABLED, QUICK_STOP) else SWITCH_ON_DISABLED
    if word & 0xF == 6:
        return READY
    if state == SWITCH_ON_DISABLED:
        return state
    return {7: SWITCHED_ON, 15: SWITCHED_ON if state == READY else ENABLED}.get(word & 0xF, state)


class Device:
    def __init__(self, bus, node, lie):
        self.bus, self.node, self.lie = bus, node, lie
        self.seen = {"aborts": [], "commands": [], "enabled": False, "syncs": 0, "furthest": 0, "uploads": 0, "power_cycles": 0}
        self.later = []  # (time, frame) to be sent
        self.switch_on()

    def switch_on(self):
        """As after power-on: what the master has set is lost."""
        self.values = {key: value if isinstance(value, bytes) else value[0] for key, value in OBJECTS.items()}
        for index, base in ((0x1400, 0x200), (0x1401, 0x300), (0x1800, 0x180), (0x1801, 0x280)):
            self.values[index, 1] = base + self.node
        self.values[0x1014, 0] += self.node
        self.nmt, self.drive = PRE_OPERATIONAL, SWITCH_ON_DISABLED
        self.transfer, self.toggle, self.address = None, 0, (0, 0)
        self.heartbeat_at, self.shown = None, {}
        self.send(0x700 + self.node, b"\0")
        if self.lie == "boots_to_operational":
            self.nmt = OPERATIONAL
            self.send(0x700 + self.node, bytes([OPERATIONAL]))

    def send(self, identifier, payload):
        self.bus.send(can.Message(arbitration_id=identifier, is_extended_id=False, data=payload))

    def pack(self, key):
        value = self.values[key]
        return value if isinstance(value, bytes) else (value % (1 << 8 * OBJECTS[key][1])).to_bytes(OBJECTS[key][1], "little")

    def run(self):
        while True:
            message = self.bus.recv(0.002)
            if message is not None and not message.is_error_frame and not message.is_extended_id:
                self.receive(message.arbitration_id, bytes(message.data), message.is_remote_frame)
            now = time.monotonic()
            while self.later and self.later[0][0] <= now:
                self.send(*self.later.pop(0)[1])
            self.beat(now)
            if message is None and select.select([sys.stdin], [], [], 0)[0] and not sys.stdin.read(1):
                return

    def beat(self, now):
        interval = self.values[0x1017, 0] / 1000
        if not interval:
            return
        if self.heartbeat_at is None or now >= self.heartbeat_at:
            self.heartbeat_at = now + interval
            lost = self.lie == "heartbeat_ends" and self.seen["enabled"]
            if not lost:
                self.send(0x700 + self.node, bytes([STOPPED if self.lie == "heartbeat_of_stopped" and self.nmt == OPERATIONAL
                                                    else self.nmt]))

    def receive(self, identifier, data, remote):
        if identifier == 0 and len(data) == 2 and data[1] in (0, self.node):
            self.command(data[0])
        elif identifier == 0x600 + self.node and len(data) == 8 and self.nmt != STOPPED and not remote:
            self.answer(self.sdo(data))
        elif identifier == 0x700 + self.node and remote:
            self.send(identifier, bytes([self.nmt]))
        elif self.nmt == OPERATIONAL and identifier == 0x80:
            self.synchronised()
        elif self.nmt == OPERATIONAL and not remote:
            for index in (0x1400, 0x1401):
                if identifier == self.values[index, 1]:
                    self.take(index + 0x200, data)

    def command(self, command):
        self.seen["commands"].append(command)
        if command in (0x81, 0x82):
            self.switch_on()
        elif command in COMMANDS:
            self.nmt = COMMANDS[command]
            if self.nmt == OPERATIONAL:
                self.shown = {}
                self.event()

    def mapped(self, mapping):
        for sub in range(1, self.values[mapping, 0] + 1):
            entry = self.values[mapping, sub]
            yield (entry >> 16, entry >> 8 & 0xFF), (entry & 0xFF) // 8

    def take(self, mapping, data):
        for key, size in self.mapped(mapping):
            self.values[key] = int.from_bytes(data[:size], "little", signed=True)
            data = data[size:]
        self.values[0x6061, 0] = self.values[0x6060, 0]
        self.event()

    def event(self):
        """Sends the event-driven TPDOs whose values have changed."""
        for number in range(2):
            content = b"".join(self.pack(key)[:size] for key, size in self.mapped(0x1A00 + number))
            if self.values[0x1800 + number, 2] >= 254 and content and content != self.shown.get(number):
                self.shown[number] = content
                self.send(self.values[0x1800 + number, 1] & 0x7FF, content)

    def synchronised(self):
        self.seen["syncs"] += 1
        word = self.values[0x6040, 0]
        self.drive = next_state(self.drive, word)
        moves = self.drive == ENABLED and word & 0x10
        self.seen["enabled"] = self.seen["enabled"] or self.drive == ENABLED
        if moves:
            self.values[0x6064, 0] = self.values[0x60C1, 1]
            self.seen["furthest"] = max(self.seen["furthest"], self.values[0x6064, 0])
        self.values[0x6041, 0] = self.drive | ALWAYS | (IN_MOTION if moves else 0)
        for number in range(2):
            content = b"".join(self.pack(key)[:size] for key, size in self.mapped(0x1A00 + number))
            if self.values[0x1800 + number, 2] <= 240 and content:
                short = self.lie == "short_pdo" and self.seen["enabled"]
                self.send(self.values[0x1800 + number, 1] & 0x7FF, content[:3] if short else content)
        if self.lie == "emergencies" and self.seen["syncs"] % 20 == 10:
            for content in (b"", b"\0\0\0", bytes(8), b"\x34\x12\xff\1\2\3\4\5", b"\xff" * 7):
                self.send(0x80 + self.node, content)
        if self.lie == "power_cycle" and moves and self.seen["syncs"] > 60 and not self.seen["power_cycles"]:
            self.seen["power_cycles"] += 1
            time.sleep(0.4)
            while self.bus.recv(0) is not None:  # what a device without power does not hear
                pass
            self.switch_on()

    def answer(self, answer):
        if answer is None or self.lie == "silent":
            return
        frame = (0x580 + self.node, answer)
        if self.lie == "late":
            self.later.append((time.monotonic() + LATE_S, frame))
        else:
            self.send(*frame)

    def abort(self, code):
        self.transfer = None
        return struct.pack("<BHBI", 0x80, *self.address, code)

    def sdo(self, data):
        specifier = data[0] >> 5
        if specifier in (1, 2):
            self.address = struct.unpack_from("<HB", data, 1)
            self.toggle = 0
            if self.address not in self.values:
                return self.abort(0x06020000)
        if specifier == 4:
            self.seen["aborts"].append(struct.unpack_from("<I", data, 4)[0])
            self.transfer = None
            return None
        return {0: self.download_segment, 1: self.download, 2: self.upload, 3: self.upload_segment}.get(
            specifier, lambda _: self.abort(0x05040001))(data)

    def upload(self, _):
        self.seen["uploads"] += 1
        content = self.pack(self.address)
        index, sub = self.address
        if self.address == (0x1018, 2) and self.lie in ("two_gibibytes", "too_short", "too_long"):
            self.transfer = content
            size = {"two_gibibytes": 1 << 31, "too_short": 20, "too_long": 3}[self.lie]
            return struct.pack("<BHBI", 0x41, index, sub, size)
        if self.lie == "another_object":
            index += 1
        if self.lie == "another_device" and self.address == (0x1018, 1):
            content = b"\x66\x05\0\0"
        if len(content) <= 4:
            return struct.pack("<BHB", 0x43 | (4 - len(content)) << 2, index, sub) + content.ljust(4, b"\0")
        self.transfer = content
        return struct.pack("<BHBI", 0x41, index, sub, len(content))

    def segment_toggle(self):
        """The toggle bit of an answer."""
        toggle, self.toggle = self.toggle, self.toggle ^ 0x10
        return toggle ^ (0x10 if self.lie == "wrong_toggle" else 0)

    def upload_segment(self, _):
        if self.transfer is None:
            return self.abort(0x05040001)
        part, self.transfer = self.transfer[:7], self.transfer[7:]
        last = not self.transfer
        return bytes([self.segment_toggle() | (7 - len(part)) << 1 | last]) + part.ljust(7, b"\0")

    def download(self, data):
        answer = struct.pack("<BHB4x", 0x60, *self.address)
        if not data[0] & 2:
            self.transfer = b""
            return answer
        size = 4 - (data[0] >> 2 & 3) if data[0] & 1 else 4
        return self.store(data[4:4 + size]) or answer

    def download_segment(self, data):
        if self.transfer is None:
            return self.abort(0x05040001)
        self.transfer += data[1:8 - (data[0] >> 1 & 7)]
        refused = self.store(self.transfer) if data[0] & 1 else None
        return refused or bytes([0x20 | self.segment_toggle()]) + bytes(7)

    def store(self, content):
        if isinstance(OBJECTS[self.address], bytes):
            self.values[self.address] = content
            return None
        if len(content) != OBJECTS[self.address][1]:
            return self.abort(0x06070010)
        self.values[self.address] = int.from_bytes(content, "little")
        if self.address == (0x1017, 0):
            self.heartbeat_at = None
        if self.address == (0x6060, 0):
            self.values[0x6061, 0] = self.values[0x6060, 0]
        return None


def main():
    settings, node, lie = json.loads(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    with can.Bus(**settings) as bus:
        device = Device(bus, node, lie)
        print("ready", file=sys.stderr, flush=True)
        device.run()
        print(json.dumps({**device.seen, "position": device.values[0x6064, 0], "setting": device.values[0x2001, 0].decode(),
                          "state": device.nmt}))


if __name__ == "__main__":
    main()
