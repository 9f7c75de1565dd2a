"""A CANopen master of a few lines on python-can: can_master.py '{"interface": "slcan", "channel": ...}' SCENARIO NODE
prints one JSON document with what it has seen. Run by test_can.py with an interpreter that has python-can."""
import json
import struct
import sys
import time

import can

PATIENCE_S = 30
EXPEDITED = {1: 0x2F, 2: 0x2B, 4: 0x23}


class Master:
    def __init__(self, bus):
        self.bus = bus
        self.others = []  # frames that were not waited for

    def send(self, identifier, payload=b"", remote=False, length=0):
        self.bus.send(can.Message(arbitration_id=identifier, is_extended_id=False, is_remote_frame=remote,
                                  data=None if remote else payload, dlc=length if remote else len(payload)))

    def receive(self, identifier, patience=PATIENCE_S):
        """The data of the next frame with this identifier; None when none comes."""
        deadline = time.monotonic() + patience
        while (left := deadline - time.monotonic()) > 0:
            message = self.bus.recv(left)
            if message is None or message.is_error_frame:
                continue
            if message.arbitration_id == identifier and not message.is_remote_frame:
                return bytes(message.data)
            self.others.append((message.arbitration_id, bytes(message.data)))
        return None

    def nmt(self, command, node):
        self.send(0x000, bytes([command, node]))

    def ask(self, node, request, patience=PATIENCE_S):
        self.send(0x600 + node, request)
        return self.receive(0x580 + node, patience)

    def upload(self, node, index, subindex=0, patience=PATIENCE_S):
        """The bytes of an object; the abort code as a number; None without an answer."""
        answer = self.ask(node, struct.pack("<BHB4x", 0x40, index, subindex), patience)
        if answer is None:
            return None
        if answer[0] == 0x80:
            return struct.unpack_from("<I", answer, 4)[0]
        if answer[0] & 2:
            return answer[4:8 - (answer[0] >> 2 & 3 if answer[0] & 1 else 0)]
        data, toggle = b"", 0
        while True:
            answer = self.ask(node, bytes([0x60 | toggle]) + bytes(7))
            data += answer[1:8 - (answer[0] >> 1 & 7)]
            if answer[0] & 1:
                return data
            toggle ^= 0x10

    def number(self, node, index, subindex=0):
        return int.from_bytes(self.upload(node, index, subindex), "little", signed=True)

    def download(self, node, index, subindex, value, size):
        """0, or the abort code."""
        answer = self.ask(node, struct.pack("<BHB", EXPEDITED[size], index, subindex)
                          + value.to_bytes(size, "little", signed=value < 0).ljust(4, b"\0"))
        return 0 if answer[0] == 0x60 else struct.unpack_from("<I", answer, 4)[0]

    def download_text(self, node, index, text):
        """A segmented download; 0, or the abort code."""
        answer = self.ask(node, struct.pack("<BHBI", 0x21, index, 0, len(text)))
        toggle = 0
        while answer[0] != 0x80 and text:
            part, text = text[:7], text[7:]
            command = toggle | (7 - len(part)) << 1 | (0 if text else 1)
            answer = self.ask(node, bytes([command]) + part.ljust(7, b"\0"))
            toggle ^= 0x10
        return struct.unpack_from("<I", answer, 4)[0] if answer[0] == 0x80 else 0

    def until(self, holds):
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            if holds():
                return True
        return False

    def map(self, node, index, entries, kind):
        cob_id = self.number(node, index, 1) & 0xFFFFFFFF
        mapping = index + 0x200
        codes = [self.download(node, index, 1, cob_id | 1 << 31, 4), self.download(node, index, 2, kind, 1),
                 self.download(node, mapping, 0, 0, 1)]
        codes += [self.download(node, mapping, i, entry, 4) for i, entry in enumerate(entries, 1)]
        codes += [self.download(node, mapping, 0, len(entries), 1), self.download(node, index, 1, cob_id, 4)]
        return codes


def scan(master, _node):
    """Which of the nodes 1 to 9 answer, and what they are."""
    return {node: master.upload(node, 0x1018, 2, patience=1 if node > 8 else PATIENCE_S) for node in range(1, 10)}


def services(master, node):
    """SDO of every kind, error control, and where no answer comes."""
    seen = {"name": master.download_text(node, 0x2003, b"the axis behind the door")}
    seen["name_back"] = master.upload(node, 0x2003).rstrip(b"\0").decode()
    seen["device_type"] = master.upload(node, 0x1000).hex()
    seen["missing"] = master.upload(node, 0x5FFF)
    seen["read_only"] = master.download(node, 0x6041, 0, 7, 2)
    seen["too_long"] = master.download(node, 0x6060, 0, 1, 4)
    master.send(0x700 + node, remote=True, length=1)
    seen["guarding"] = [(master.receive(0x700 + node, 5) or b"").hex()]
    master.send(0x700 + node, remote=True, length=1)
    seen["guarding"].append((master.receive(0x700 + node, 5) or b"").hex())
    seen["heartbeat_time"] = master.download(node, 0x1017, 0, 50, 2)
    master.nmt(0x01, node)
    seen["heartbeats"] = [master.receive(0x700 + node).hex() for _ in range(3)][1:]
    master.nmt(0x82, node)  # reset communication
    seen["boot_up"] = master.until(lambda: master.receive(0x700 + node) == b"\0")
    return seen


def profile_move(master, node):
    """A move in profile position by SDO and PDO."""
    turn = 1 << 20
    codes = [master.download(node, *one) for one in ((0x6081, 0, 20 * turn, 4), (0x6083, 0, 100 * turn, 4),
                                                     (0x6084, 0, 90 * turn, 4), (0x6060, 0, 1, 1))]
    codes += master.map(node, 0x1400, [0x60400010], 255)
    codes += master.map(node, 0x1401, [0x607A0020], 255)
    master.nmt(0x01, node)
    start = master.number(node, 0x6064)
    for word, state in ((6, 0x21), (7, 0x23), (15, 0x27)):
        master.send(0x200 + node, struct.pack("<H", word))
        if not master.until(lambda state=state: master.number(node, 0x6041) & 0x6F == state):
            return {"codes": codes, "stuck_at": word, "status": master.number(node, 0x6041)}
    master.send(0x300 + node, struct.pack("<i", start + 3 * turn + 777))
    master.send(0x200 + node, struct.pack("<H", 31))
    acknowledged = master.until(lambda: master.number(node, 0x6041) & 0x1000)
    reached = master.until(lambda: master.number(node, 0x6041) & 0x0400)
    time.sleep(0.2)
    return {"codes": codes, "acknowledged": acknowledged, "reached": reached,
            "distance": master.number(node, 0x6064) - start}


def interpolated_move(master, node):
    """A move in interpolated position: this master sends a position and SYNC about every 10 ms. Pauses are not made up for,
    which would be a leap."""
    turn = 1 << 20
    codes = [master.download(node, 0x1006, 0, 10_000, 4), master.download(node, 0x60C2, 1, 10, 1),
             master.download(node, 0x2132, 0, struct.unpack("<i", struct.pack("<f", 10.0))[0], 4),
             master.download(node, 0x6060, 0, 7, 1)]
    codes += master.map(node, 0x1400, [0x60400010], 255)
    codes += master.map(node, 0x1401, [0x60C10120], 1)
    master.nmt(0x01, node)
    start = master.number(node, 0x6064)
    master.send(0x300 + node, struct.pack("<i", start))
    master.send(0x080)
    for word, state in ((6, 0x21), (7, 0x23), (15, 0x27)):
        master.send(0x200 + node, struct.pack("<H", word))
        if not master.until(lambda state=state: master.number(node, 0x6041) & 0x6F == state):
            return {"codes": codes, "stuck_at": word, "status": master.number(node, 0x6041)}
    master.send(0x200 + node, struct.pack("<H", 31))
    steps = 200
    for step in range(1, steps + 31):
        share = min(step / steps, 1.0)
        smooth = share * share * (3.0 - 2.0 * share)
        master.send(0x300 + node, struct.pack("<i", start + round((turn + 333) * smooth)))
        master.send(0x080)
        time.sleep(0.01)
    reached = master.until(lambda: abs(master.number(node, 0x6064) - start - turn - 333) < 100)
    return {"codes": codes, "reached": reached, "status": master.number(node, 0x6041),
            "distance": master.number(node, 0x6064) - start}


SCENARIOS = {"scan": scan, "services": services, "profile": profile_move, "interpolated": interpolated_move}


def main():
    settings, scenario, node = json.loads(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    with can.Bus(**settings) as bus:
        seen = SCENARIOS[scenario](Master(bus), node)
    print(json.dumps(seen, default=lambda value: value.hex()))


if __name__ == "__main__":
    main()
