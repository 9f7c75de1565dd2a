#!/usr/bin/env python3
"""make_topics.py TOPICS OUTPUT IDL...: makes the table of topics of driveline-dds (schema.hpp) out of the list of topics and
the IDL files: fields as the decoder walks through them, and the message definitions of ROS 2 that a recording carries.

Knows the part of IDL that ours are written in: modules, enumerations, @final structures of numbers, booleans, strings,
enumerations, structures, sequences and arrays of these. Anything else ends the build with file and line; nothing is passed over."""
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

# IDL type: kind in schema.hpp, type in message definitions of ROS 2, size in CDR.
PRIMITIVES = {
    "boolean": ("kBool", "bool", 1), "octet": ("kUint8", "uint8", 1),
    "short": ("kInt16", "int16", 2), "unsigned short": ("kUint16", "uint16", 2),
    "long": ("kInt32", "int32", 4), "unsigned long": ("kUint32", "uint32", 4),
    "long long": ("kInt64", "int64", 8), "unsigned long long": ("kUint64", "uint64", 8),
    "float": ("kFloat", "float32", 4), "double": ("kDouble", "float64", 8),
}
MOST_KEY_BYTES = 16  # of a key that is its own hash (RTPS 2.2, 9.6.3.8)


class Complaint(Exception):
    """One sentence with file and line."""


@dataclass
class Member:
    name: str
    type: str  # a key of PRIMITIVES, "string", or the full name of an Enumeration or Structure
    sequence: bool
    count: int  # of an array; 0: it is none
    key: bool
    comment: str


@dataclass
class Enumeration:
    name: str
    values: list = field(default_factory=list)


@dataclass
class Structure:
    name: str
    members: list = field(default_factory=list)


TOKEN = re.compile(r"(?P<space>\s+)|//(?P<comment>[^\n]*)|(?P<word>@?[A-Za-z_]\w*(?:::[A-Za-z_]\w*)*)|(?P<number>\d+)"
                   r"|(?P<sign>[{}<>;,\[\]])")


class Parser:
    def __init__(self, file, types):
        self.file, self.types = file, types
        self.text = file.read_text(encoding="utf-8")
        self.tokens = []  # (text, line)
        self.comments = {}  # by line
        self.at, self.scope = 0, []
        self.split()

    def fail(self, sentence, line=None):
        raise Complaint(f"{self.file}:{self.line() if line is None else line}: {sentence}")

    def split(self):
        position, line = 0, 1
        while position < len(self.text):
            match = TOKEN.match(self.text, position)
            if match is None:
                self.fail(f"{self.text[position]!r} is not expected", line)
            if match["comment"] is not None:
                self.comments[line] = match["comment"].strip(" /")
            elif match["space"] is None:
                self.tokens.append((match[0], line))
            line += match[0].count("\n")
            position = match.end()
        self.tokens.append(("end of file", line))

    def line(self):
        return self.tokens[min(self.at, len(self.tokens) - 1)][1]

    def peek(self):
        return self.tokens[self.at][0]

    def next(self):
        self.at += 1
        return self.tokens[self.at - 1][0]

    def expect(self, *texts):
        if self.peek() not in texts:
            self.fail(f"{self.peek()!r} where {' or '.join(map(repr, texts))} is expected")
        return self.next()

    def name(self):
        if not re.fullmatch(r"[A-Za-z_]\w*", self.peek()):
            self.fail(f"{self.peek()!r} is no name")
        return self.next()

    def full(self, name):
        return "::".join([*self.scope, name])

    def find(self, name):
        """A type seen from the scope where it is used."""
        for depth in range(len(self.scope), -1, -1):
            full = "::".join([*self.scope[:depth], name])
            if full in self.types:
                return full
        return self.fail(f"there is no type {name}")

    def file_content(self):
        while self.peek() != "end of file":
            self.declaration()

    def declaration(self):
        keyword = self.expect("module", "enum", "@final")
        if keyword == "module":
            self.scope.append(self.name())
            self.expect("{")
            while self.peek() != "}":
                self.declaration()
            self.next()
            self.scope.pop()
        elif keyword == "enum":
            self.enumeration()
        else:
            self.expect("struct")
            self.structure()
        self.expect(";")

    def enumeration(self):
        made = Enumeration(self.full(self.name()))
        self.expect("{")
        made.values.append(self.name())
        while self.expect(",", "}") == ",":
            made.values.append(self.name())
        self.types[made.name] = made

    def structure(self):
        made = Structure(self.full(self.name()))
        self.expect("{")
        while self.peek() != "}":
            made.members.append(self.member())
        if not made.members:
            self.fail("a structure without members is no message of ROS 2")
        self.next()
        self.types[made.name] = made

    def member(self):
        key = self.peek() == "@key"
        if key:
            self.next()
        sequence = self.peek() == "sequence"
        if sequence:
            self.next()
            self.expect("<")
            kind = self.type()
            self.bound()
            self.expect(">")
        else:
            kind = self.type()
        line = self.line()
        name = self.name()
        if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
            self.fail(f"{name!r} is no name of a field in ROS 2: small letters, digits and underscores", line)
        count = self.array()
        if sequence and count:
            self.fail(f"{name!r} is an array of sequences, which ROS 2 does not know", line)
        if key and (sequence or count or kind not in PRIMITIVES):
            self.fail(f"key {name!r} is not a number: its hash would have to be computed otherwise", line)
        self.expect(";")
        return Member(name, kind, sequence, count, key, self.comments.get(line, ""))

    def array(self):
        """The number of elements behind a name; 0: it is no array."""
        if self.peek() != "[":
            return 0
        self.next()
        if not self.peek().isdigit() or int(self.peek()) == 0:
            self.fail("the size of an array is a number")
        count = int(self.next())
        self.expect("]")
        return count

    def bound(self):
        if self.peek() == ",":
            self.next()
            if not self.next().isdigit():
                self.fail("the bound of a sequence is a number")

    def type(self):
        words = [self.next()]
        if words[0] == "unsigned":
            words.append(self.next())
        if words[-1] == "long" and self.peek() == "long":
            words.append(self.next())
        text = " ".join(words)
        if text == "string":
            if self.peek() == "<":
                self.next()
                if not self.next().isdigit():
                    self.fail("the bound of a string is a number")
                self.expect(">")
            return text
        return text if text in PRIMITIVES else self.find(text)


def ros_name(name, separator="/"):
    """`driveline::telemetry::Event` is `driveline/Event`, `std_msgs::msg::dds_::Header_` is `std_msgs/Header`."""
    parts = name.split("::")
    return f"{parts[0]}{separator}{parts[-1].removesuffix('_')}"


def is_ros(name):
    """Members of the types of ROS 2 itself have an underscore behind them on the wire."""
    return "::dds_::" in name


def member_name(structure, member):
    return member.name.removesuffix("_") if is_ros(structure.name) else member.name


def contained(structure, types, found=None):
    """The structures inside one, each once."""
    found = [] if found is None else found
    for member in structure.members:
        inner = types.get(member.type)
        if isinstance(inner, Structure) and inner not in found:
            found.append(inner)
            contained(inner, types, found)
    return found


def definition(structure, types):
    """A message definition of ROS 2. Strings and sequences have no bounds in it: the bytes are the same, and readers that
    do not know bounds exist."""
    lines, enumerations = [], []
    for member in structure.members:
        known = types.get(member.type)
        if isinstance(known, Enumeration):
            ros = "uint32"
            if known not in enumerations:
                enumerations.append(known)
                lines += [f"uint32 {name}={number}" for number, name in enumerate(known.values)]
        elif isinstance(known, Structure):
            ros = ros_name(known.name)
        else:
            ros = "string" if member.type == "string" else PRIMITIVES[member.type][1]
        comment = f"  # {member.comment}" if member.comment else ""
        many = "[]" if member.sequence else f"[{member.count}]" if member.count else ""
        lines.append(f"{ros}{many} {member_name(structure, member)}{comment}")
    return "\n".join(lines) + "\n"


def schema(structure, types):
    """The definition and those that it needs, as recordings have them: separated by a line of 80 signs."""
    text = definition(structure, types)
    for inner in contained(structure, types):
        text += f"{'=' * 80}\nMSG: {ros_name(inner.name)}\n{definition(inner, types)}"
    return text


def symbol(name):
    return "k" + "".join(part[:1].upper() + part[1:] for part in re.split(r"::|_", name))


def field_initializer(structure, member, types):
    known = types.get(member.type)
    if isinstance(known, Enumeration):
        kind, enumeration, inner = "kEnum", "&" + symbol(known.name), "nullptr"
    elif isinstance(known, Structure):
        kind, enumeration, inner = "kStruct", "nullptr", "&" + symbol(known.name)
    else:
        kind = "kString" if member.type == "string" else PRIMITIVES[member.type][0]
        enumeration = inner = "nullptr"
    flags = f"{str(member.sequence).lower()}, {member.count}, {str(member.key).lower()}"
    return f'    {{"{member_name(structure, member)}", Kind::{kind}, {flags}, {enumeration}, {inner}}},'


def types_text(types):
    lines = []
    for made in types.values():
        at = symbol(made.name)
        if isinstance(made, Enumeration):
            names = ", ".join(f'"{name}"' for name in made.values)
            lines += [f"constexpr std::string_view {at}Names[] = {{{names}}};", f"constexpr EnumType {at}{{{at}Names}};"]
        else:
            lines += [f"constexpr Field {at}Fields[] = {{",
                      *(field_initializer(made, member, types) for member in made.members), "};",
                      f'constexpr StructType {at}{{"{ros_name(made.name)}", {at}Fields}};']
    return "\n".join(lines)


@dataclass
class Row:
    topic: str
    structure: Structure
    reliable: bool
    kept: bool
    counter: str = ""
    counter_of: str = ""
    rows: str = ""
    partner_index: str = ""
    partners: str = ""


def read_row(words, types, fail):
    if len(words) != 5:
        fail("five words are expected: topic, type, writer, gaps, rows")
    topic, name, writer, gaps, rows = words
    structure = types.get(name)
    if not isinstance(structure, Structure):
        fail(f"no structure {name} in the IDL")
    if writer not in ("best_effort", "reliable", "kept"):
        fail(f"writer {writer!r}: best_effort, reliable or kept is expected")
    row = Row(topic, structure, writer != "best_effort", writer == "kept")
    if gaps != "-":
        row.counter, _, row.counter_of = gaps.partition("/")
    if rows != "-":
        match = re.fullmatch(r"(\w+)(?::(\w+)=(\w+))?", rows)
        if match is None:
            fail(f"rows {rows!r}: SEQUENCE or SEQUENCE:INDEX=PARTNERS is expected")
        row.rows, row.partner_index, row.partners = (part or "" for part in match.groups())
    check_fields(row, types, fail)
    return row


def check_fields(row, types, fail):
    members = {member_name(row.structure, member): member for member in row.structure.members}
    whole = [kind for kind, (kind_of_ros, _, _) in PRIMITIVES.items() if kind_of_ros not in ("kFloat", "kDouble")]
    for name in filter(None, (row.counter, row.counter_of)):
        if name not in members or members[name].sequence or members[name].count or members[name].type not in whole:
            fail(f"{name} is no whole number of {row.structure.name}")
    for name in filter(None, (row.rows, row.partners)):
        if name not in members or not members[name].sequence or not isinstance(types.get(members[name].type), Structure):
            fail(f"{name} is no sequence of structures of {row.structure.name}")
    if row.partner_index and row.partner_index not in [m.name for m in types[members[row.rows].type].members]:
        fail(f"{row.partner_index} is no field of {row.rows}")
    if sum(PRIMITIVES[member.type][2] for member in row.structure.members if member.key) > MOST_KEY_BYTES:
        fail(f"the key of {row.structure.name} is longer than {MOST_KEY_BYTES} bytes")


def read_topics(file, types):
    rows = []
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
        def fail(sentence, at=number):
            raise Complaint(f"{file}:{at}: {sentence}")
        if line.strip() and not line.startswith("#"):
            row = read_row(line.split(), types, fail)
            if row.topic in [other.topic for other in rows]:
                fail(f"topic {row.topic} has a row already")
            rows.append(row)
    inner = [part for made in types.values() if isinstance(made, Structure) for part in contained(made, types)]
    for made in types.values():
        if isinstance(made, Structure) and made not in inner and made not in [row.structure for row in rows]:
            raise Complaint(f"{file}: no topic has the type {made.name}, and no other type contains it")
    return rows


def row_text(row, types):
    flags = f"{str(row.reliable).lower()}, {str(row.kept).lower()}"
    return (f'    {{"{row.topic}", "{row.structure.name}", "{ros_name(row.structure.name, "/msg/")}", '
            f'R"schema({schema(row.structure, types)})schema",\n     &{symbol(row.structure.name)}, {flags}, "{row.counter}", '
            f'"{row.counter_of}", "{row.rows}", "{row.partner_index}", "{row.partners}"}},')


def make(topics_file, idl_files):
    types = {}
    for file in idl_files:
        Parser(file, types).file_content()
    rows = read_topics(topics_file, types)
    return "\n".join([
        "// Made by bridge/clients/make_topics.py.", '#include "schema.hpp"', "", "namespace driveline::bridge::clients {",
        "namespace {", "", types_text(types), "", "constexpr Topic kTopics[] = {",
        *(row_text(row, types) for row in rows), "};", "", "}  // namespace", "",
        "std::span<const Topic> topics() noexcept {", "  return kTopics;", "}", "", "}  // namespace driveline::bridge::clients", ""])


def main():
    topics_file, output, *idl_files = map(Path, sys.argv[1:])
    try:
        text = make(topics_file, idl_files)
    except Complaint as complaint:
        sys.exit(f"make_topics.py: {complaint}")
    output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
