#!/usr/bin/env python3
"""read_recording.py FILE.mcap [TOPIC]: reads a recording of `driveline record` with Python alone. It lists the topics, or prints
the samples of one as JSON. In a program of your own: for topic, log_time_ns, sample in read_recording.samples(file)."""
import json
import math
import struct
import sys
from pathlib import Path

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15
NUMBERS = {"bool": "?", "uint8": "B", "byte": "B", "int8": "b", "uint16": "H", "int16": "h", "uint32": "I", "int32": "i",
           "uint64": "Q", "int64": "q", "float32": "f", "float64": "d"}


def records(data, at=0):
    """Opcode and content of each record; ends where the file was cut off."""
    while at + 9 <= len(data):
        opcode, length = struct.unpack_from("<BQ", data, at)
        if at + 9 + length > len(data):
            return
        yield opcode, data[at + 9:at + 9 + length]
        at += 9 + length


def string(data, at):
    """A string with its length in front, and where it ends."""
    size, = struct.unpack_from("<I", data, at)
    return data[at + 4:at + 4 + size].decode("utf-8"), at + 4 + size


class Schema:
    """A message definition of ROS 2 (ros2msg), and the definitions behind it that it needs."""

    def __init__(self, name, text):
        package, self.main = name.split("/")[0], name.replace("/msg/", "/")
        self.fields, self.names = {}, {}  # by type: (type, how many, name); by type and field: names of its values
        for i, part in enumerate(text.split("=" * 80 + "\n")):
            of, lines = self.main, part.splitlines()
            if i > 0:
                of, lines = lines[0].removeprefix("MSG: "), lines[1:]
            constants = {}
            for kind, name in (line.split("#")[0].split() for line in lines if line.split("#")[0].strip()):
                if "=" in name:
                    constants[int(name.split("=")[1])] = name.split("=")[0]
                    continue
                single, _, many = kind.removesuffix("]").partition("[")
                if single not in NUMBERS and single != "string" and "/" not in single:
                    single = f"{package}/{single}"
                self.fields.setdefault(of, []).append((single, many if "[" in kind else None, name))
                if constants:  # they stand in front of the field that takes them
                    self.names[of, name], constants = constants, {}

    def sample(self, data):
        """A sample in plain CDR, in the byte order that its first bytes tell; enumerations by name."""
        self.data, self.at, self.order = data[4:], 0, "<" if data[1] == 1 else ">"
        return self.structure(self.main)

    def number(self, code):
        size = struct.calcsize(code)
        self.at = -(-self.at // size) * size  # numbers are aligned to their size
        value, = struct.unpack_from(self.order + code, self.data, self.at)
        self.at += size
        return value

    def value(self, kind):
        if kind in NUMBERS:
            return self.number(NUMBERS[kind])
        if kind != "string":
            return self.structure(kind)
        size = self.number("I")
        self.at += size
        return self.data[self.at - size:self.at - 1].decode("utf-8", "replace")

    def structure(self, kind):
        sample = {}
        for of, many, name in self.fields[kind]:
            if many is None:
                value = self.value(of)
            else:  # an array has its size in the schema, a sequence in front of its elements
                value = [self.value(of) for _ in range(int(many) if many else self.number("I"))]
            names = self.names.get((kind, name), {})
            sample[name] = names.get(value, value) if names else value
        return sample


def samples(file, topic=None):
    """(topic, log time in ns since 1970, sample as a dict) of every sample, or of those of one topic."""
    data = memoryview(Path(file).read_bytes())
    if bytes(data[:8]) != MAGIC:
        raise ValueError(f"{file}: is not an MCAP file")
    schemas, channels = {}, {}
    yield from content(bytes(data[8:]), schemas, channels, topic)


def content(data, schemas, channels, wanted):
    for opcode, record in records(data):
        if opcode == SCHEMA:
            name, at = string(record, 2)
            _, at = string(record, at)
            schemas[struct.unpack_from("<H", record)[0]] = Schema(name, string(record, at)[0])
        elif opcode == CHANNEL:
            number, schema = struct.unpack_from("<HH", record)
            channels[number] = string(record, 4)[0], schemas[schema]
        elif opcode == MESSAGE:
            number, _, log_time, _ = struct.unpack_from("<HIQQ", record)
            topic, schema = channels[number]
            if wanted in (None, topic):
                yield topic, log_time, schema.sample(record[22:])
        elif opcode == CHUNK:  # times, size, checksum, no compression, length of the records
            yield from content(record[40:], schemas, channels, wanted)
        elif opcode == DATA_END:
            return  # an index and statistics follow


def plain(value):
    """As JSON has it: it knows no NaN and no infinity."""
    if isinstance(value, dict):
        return {name: plain(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: read_recording.py FILE.mcap [TOPIC]")
    counts = {}
    for topic, log_time, sample in samples(*sys.argv[1:]):
        counts[topic] = counts.get(topic, 0) + 1
        if len(sys.argv) == 3:
            print(json.dumps({"log_time_ns": log_time, **plain(sample)}))
    if len(sys.argv) == 2:
        for topic, count in counts.items():
            print(f"{topic}: {count} samples")


if __name__ == "__main__":
    main()
