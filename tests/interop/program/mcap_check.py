"""Checks a MCAP file against its specification (https://mcap.dev/spec, version 0): every length, offset, count and checksum. Written
from the specification alone; shares nothing with what writes recordings, or with the reader among the examples."""
import struct
import zlib

MAGIC = b"\x89MCAP0\r\n"
(HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX, ATTACHMENT, ATTACHMENT_INDEX, STATISTICS, METADATA,
 METADATA_INDEX, SUMMARY_OFFSET, DATA_END) = range(1, 16)


class Malformed(Exception):
    """What is wrong with the file."""


def check(holds, sentence):
    if not holds:
        raise Malformed(sentence)


class Cursor:
    """Takes fields off the front of a record."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, layout):
        size = struct.calcsize("<" + layout)
        check(self.at + size <= len(self.data), f"a record of {len(self.data)} bytes is too short")
        values = struct.unpack_from("<" + layout, self.data, self.at)
        self.at += size
        return values if len(values) > 1 else values[0]

    def blob(self, size):
        check(self.at + size <= len(self.data), f"a field of {size} bytes is longer than its record")
        self.at += size
        return self.data[self.at - size:self.at]

    def text(self):
        return self.blob(self.take("I")).decode("utf-8")

    def pairs(self, layout):
        """An array or a map of fixed-size entries."""
        part = Cursor(self.blob(self.take("I")))
        entries = []
        while part.at < len(part.data):
            entries.append(part.take(layout))
        return entries

    def words(self):
        """A map of strings; each key is in it once."""
        part, entries = Cursor(self.blob(self.take("I"))), {}
        while part.at < len(part.data):
            key = part.text()
            check(key not in entries, f"{key} is in a map twice")
            entries[key] = part.text()
        return entries

    def end(self):
        check(self.at == len(self.data), f"{len(self.data) - self.at} bytes too many in a record")


def split(data, begin, end):
    """(offset, opcode, content) of the records that fill data[begin:end]."""
    at = begin
    while at < end:
        check(at + 9 <= end, "a record is cut off")
        opcode, length = struct.unpack_from("<BQ", data, at)
        check(at + 9 + length <= end, f"record {opcode:#x} at {at} is longer than what it is in")
        yield at, opcode, data[at + 9:at + 9 + length]
        at += 9 + length


class File:
    """A checked file: `messages` is a list of (topic, sequence, log time, publish time, bytes) in the order of the file."""

    def __init__(self, path):
        self.data = path.read_bytes()
        self.schemas, self.channels, self.messages = {}, {}, []
        self.chunks, self.indices = [], {}  # indices: offset of a message index: (channel, entries)
        self.metadata = []  # (offset, length, name, map)
        data = self.data
        check(data[:8] == MAGIC and data[-8:] == MAGIC and len(data) > 16, "magic bytes are missing")
        footer_at = len(data) - 8 - 9 - 20
        (_, opcode, footer), = split(data, footer_at, len(data) - 8)
        check(opcode == FOOTER, "no footer at the end")
        self.summary_at, self.offsets_at, crc = struct.unpack("<QQI", footer)
        check(crc == zlib.crc32(data[self.summary_at:len(data) - 8 - 4]), "checksum of the summary")
        self.data_section()
        self.summary(footer_at)

    def data_section(self):
        ended = False
        for number, (at, opcode, content) in enumerate(split(self.data, 8, self.summary_at)):
            check(not ended, "a record behind the end of the data")
            check((opcode == HEADER) == (number == 0), "the header comes first, and once")
            if opcode == HEADER:
                cursor = Cursor(content)
                self.profile, self.library = cursor.text(), cursor.text()
                cursor.end()
            elif opcode == CHUNK:
                self.chunk(at, content)
            elif opcode == MESSAGE_INDEX:
                self.message_index(at, content)
            elif opcode == METADATA:
                cursor = Cursor(content)
                self.metadata.append((at, 9 + len(content), cursor.text(), cursor.words()))
                cursor.end()
            elif opcode == DATA_END:
                check(struct.unpack("<I", content)[0] == zlib.crc32(self.data[:at]), "checksum of the data")
                ended = True
            else:
                self.record(opcode, content)
        check(ended, "no end of the data")

    def record(self, opcode, content, offset=None, chunk=None):
        cursor = Cursor(content)
        if opcode == SCHEMA:
            number = cursor.take("H")
            schema = (cursor.text(), cursor.text(), cursor.blob(cursor.take("I")))
            check(number != 0 and self.schemas.setdefault(number, schema) == schema, f"schema {number} has changed")
        elif opcode == CHANNEL:
            number, schema = cursor.take("HH")
            channel = (schema, cursor.text(), cursor.text(), cursor.words())
            check(schema in self.schemas, f"channel {number} comes before its schema")
            check(self.channels.setdefault(number, channel) == channel, f"channel {number} has changed")
        elif opcode == MESSAGE:
            number, sequence, log_time, publish_time = cursor.take("HIQQ")
            check(number in self.channels, f"a message comes before its channel {number}")
            check(chunk is not None, "a message outside of a chunk")
            chunk.append((number, log_time, offset))
            self.messages.append((self.channels[number][1], sequence, log_time, publish_time, content[cursor.at:]))
            return
        else:
            raise Malformed(f"record {opcode:#x} is not expected here")
        cursor.end()

    def chunk(self, at, content):
        cursor = Cursor(content)
        first, last, size, crc = cursor.take("QQQI")
        check(cursor.text() == "", "compressed: not looked into")
        records = cursor.blob(cursor.take("Q"))
        cursor.end()
        check(len(records) == size, "size of a chunk")
        check(zlib.crc32(records) == crc, "checksum of a chunk")
        inside = []
        for offset, opcode, record in split(records, 0, len(records)):
            self.record(opcode, record, offset, inside)
        times = [log_time for _, log_time, _ in inside]
        check(times and (min(times), max(times)) == (first, last), "times of a chunk")
        self.chunks.append({"at": at, "length": 9 + len(content), "times": (first, last), "size": size, "inside": inside, "indices": {}})

    def message_index(self, at, content):
        cursor = Cursor(content)
        channel, entries = cursor.take("H"), cursor.pairs("QQ")
        cursor.end()
        check(self.chunks, "a message index in front of all chunks")
        chunk = self.chunks[-1]
        expected = sorted((log_time, offset) for number, log_time, offset in chunk["inside"] if number == channel)
        check(sorted(entries) == expected, f"index of channel {channel}")
        chunk["indices"][channel] = at
        chunk["indices_end"] = at + 9 + len(content)

    def summary(self, footer_at):
        groups, statistics, chunk_indices, metadata_indices, offsets = {}, [], [], [], []
        for at, opcode, content in split(self.data, self.summary_at, footer_at):
            check((opcode == SUMMARY_OFFSET) == (at >= self.offsets_at), "offsets of the summary stand at its end")
            begin, _ = groups.get(opcode, (at, at))
            check(opcode not in groups or groups[opcode][1] == at, f"records {opcode:#x} do not stand together")
            groups[opcode] = (begin, at + 9 + len(content))
            cursor = Cursor(content)
            if opcode == STATISTICS:
                statistics.append((cursor.take("QHIIIIQQ"), dict(cursor.pairs("HQ"))))
            elif opcode == CHUNK_INDEX:
                chunk_indices.append((cursor.take("QQQQ"), dict(cursor.pairs("HQ")), cursor.take("Q"), cursor.text(), cursor.take("QQ")))
            elif opcode == METADATA_INDEX:
                metadata_indices.append((*cursor.take("QQ"), cursor.text()))
            elif opcode == SUMMARY_OFFSET:
                offsets.append(cursor.take("BQQ"))
            else:
                self.record(opcode, content)
                continue
            cursor.end()
        groups.pop(SUMMARY_OFFSET, None)
        check(sorted(offsets) == sorted((opcode, begin, end - begin) for opcode, (begin, end) in groups.items()), "offsets of the summary")
        check(metadata_indices == [(at, length, name) for at, length, name, _ in self.metadata], "indices of the metadata")
        self.check_chunk_indices(chunk_indices)
        check(len(statistics) == 1, "statistics")
        self.check_statistics(*statistics[0])

    def check_chunk_indices(self, chunk_indices):
        for chunk in self.chunks:
            check(set(chunk["indices"]) == {number for number, _, _ in chunk["inside"]}, "a channel of a chunk has no index")
        expected = [((*chunk["times"], chunk["at"], chunk["length"]), chunk["indices"],
                     chunk["indices_end"] - chunk["at"] - chunk["length"], "", (chunk["size"], chunk["size"])) for chunk in self.chunks]
        check(chunk_indices == expected, "indices of the chunks")

    def check_statistics(self, numbers, counts):
        times = [message[2] for message in self.messages] or [0]
        expected = (len(self.messages), len(self.schemas), len(self.channels), 0, len(self.metadata), len(self.chunks), min(times), max(times))
        check(numbers == expected, f"statistics {numbers}, {expected} are in the file")
        found = {number: sum(message[0] == topic for message in self.messages) for number, (_, topic, _, _) in self.channels.items()}
        check(counts == found, f"counts {counts}, {found} are in the file")
