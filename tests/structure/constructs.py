"""What a source must not be or contain: too long, packed, bitfields, casts on frames, strings as errors, silenced checks
without a reason."""
import re

from rooms import code_only, read_reasons, room_of, sources

MAX_LINES = 800
WIRE_ROOMS = {"bytes", "sdo", "wire", "canopen_wire", "canopen_port", "canopen_client", "canopen_master", "port", "snapshot", "motion", "ecat_master", "slaves"}

PACKED = re.compile(r"__attribute__\s*\(\(\s*(?:__)?packed|\[\[\s*gnu::packed|#\s*pragma\s+pack")
NOT_A_MEMBER = r"(?!.*\b(?:case|default|enum|class|struct|public|private|protected|goto|return)\b)"
BITFIELD = re.compile(
    r"^[ \t]*(?:\[\[.*?\]\][ \t]*)?" + NOT_A_MEMBER +
    r"[A-Za-z_][\w:<>,]*[ \t]+(?:[\w:<>]+[ \t]+)*\w*[ \t]*"  # type, and a name unless it is padding
    r"(?<!:):(?!:)[ \t]*\w+[ \t]*(?:=[^=;]+|\{[^}]*\}[ \t]*)?[;,]",  # width, initialiser
    re.M,
)
# Texts from files and slaves go to the terminal through console.hpp, which makes control characters visible.
PRINT = re.compile(r"\bfmt::print\b|\bstd::(?:cout|cerr|clog|puts|fputs|printf|fprintf|putchar)\b")
PRINTERS = {"cli/src/console.cpp"}
CAST = re.compile(r"\breinterpret_cast\b")
# An error of the library has facts with names, and describe() makes the sentence.
STRING_ERROR = re.compile(r"\b(?:expected\s*<[^;{}()]*,|unexpected\s*<)\s*std::string\s*>")
ERRORS_WITH_FACTS = {"rt", "wire", "canopen_wire", "canopen_port", "canopen_client", "canopen_master", "capture", "port", "snapshot", "motion", "ecat_master", "trajectory", "esi", "slaves", "bridge", "runtime"}
# The bits of a drive profile belong to its link: motions work with drives of any profile.
PROFILE_BITS = re.compile(r"\b(?:cia402::command|command_bit|status_bit|next_control_word|decode_state)\b")
PROFILE_FOLDERS = {"drive", "cia402"}
NOLINT = re.compile(r"NOLINT(?:NEXTLINE|BEGIN)?\b(?P<rest>[^\n]*)")
REASONED = re.compile(r"\([\w\-.*,| ]+\):?\s+\w.{9,}")


def line_of(text, match):
    return text.count("\n", 0, match.start()) + 1


def file_errors(path, text, casts):
    """Errors of one source. `path` is relative to the project folder."""
    errors = []
    lines = text.count("\n")
    if lines > MAX_LINES:
        errors.append(f"{path} has {lines} lines; the limit is {MAX_LINES}, split it along its nouns")
    for match in NOLINT.finditer(text):
        if not REASONED.match(match.group("rest").strip()):
            errors.append(f"{path}:{line_of(text, match)}: NOLINT needs the check and a reason: NOLINT(check): why")
    if room_of(path) in WIRE_ROOMS:
        code = code_only(text)
        for pattern, what in ((PACKED, "a packed layout"), (BITFIELD, "a bitfield")):
            for match in pattern.finditer(code):
                errors.append(f"{path}:{line_of(code, match)}: {what}; frames go through the codec of wire")
        if str(path) not in casts:
            for match in CAST.finditer(code):
                errors.append(f"{path}:{line_of(code, match)}: reinterpret_cast; "
                              "only files named with a reason in allowed_casts.txt may")
    if room_of(path) in ERRORS_WITH_FACTS:
        code = code_only(text)
        for match in STRING_ERROR.finditer(code):
            errors.append(f"{path}:{line_of(code, match)}: a bare string as an error; give it a type with the facts")
    if room_of(path) == "motion" and path.parent.name not in PROFILE_FOLDERS:
        code = code_only(text)
        for match in PROFILE_BITS.finditer(code):
            errors.append(f"{path}:{line_of(code, match)}: {match.group()} outside of the drive's link; ask DriveLink")
    if room_of(path) == "cli" and str(path) not in PRINTERS:
        code = code_only(text)
        for match in PRINT.finditer(code):
            errors.append(f"{path}:{line_of(code, match)}: {match.group()}; the program prints through console.hpp")
    return errors


def check(root, casts_file):
    casts = read_reasons(casts_file)
    errors = [f"{casts_file.name}: {path} is listed without a reason" for path, why in casts.items() if len(why) < 10]
    errors += [f"{casts_file.name}: {path} does not exist" for path in casts if not (root / path).is_file()]
    for path in sources(root):
        errors += file_errors(path, (root / path).read_text(encoding="utf-8"), casts)
    return errors
