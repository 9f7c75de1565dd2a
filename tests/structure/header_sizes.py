"""Bounds what a source pays for including one public header: the preprocessed size of the header and all it includes.

One run of the preprocessor over all public headers gives what each file contributes and includes. The size of a header
is the sum over the files that it reaches, so the check costs one preprocessor run instead of one per header.
"""
import re
import subprocess

from rooms import FOLDERS, room_of

KB = 1000
MARKER = re.compile(r'^# \d+ "([^"]+)"((?: \d)*)$')
# Libraries that cost each source that includes them a second or more.
HEAVY = {"nlohmann-json": "/nlohmann/", "toml++": "/toml++/", "Eigen": "/Eigen/", "fmt": "/fmt/", "CLI11": "/CLI/",
         "Fast DDS": "/fastdds/", "pugixml": "/pugixml"}
DIRECTIVE = re.compile(r'^#include(?:_next)? [<"]([^>"]+)[>"]$')


def public_headers(root):
    return sorted(header for folder in FOLDERS for header in (root / folder / "include").rglob("*.hpp"))


def first_error(text):
    return next((line for line in text.splitlines() if "error" in line), "it says nothing")


def preprocess(compiler, root, headers, generated):
    """Output of the preprocessor for a source that includes all headers; include directives stay in it."""
    folders = [str(root / folder / "include") for folder in FOLDERS] + [str(folder) for folder in generated]
    # By the names that other headers use: files_of() recognises a header that was read before by its name.
    source = "".join(f'#include "{str(header).rpartition("/include/")[2]}"\n' for header in headers)
    command = [compiler, "-std=c++20", "-E", "-dI", "-x", "c++", *(f"-I{folder}" for folder in folders), "-"]
    done = subprocess.run(command, input=source, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"the public headers cannot be preprocessed: {first_error(done.stderr)}")
    return done.stdout


def files_of(output):
    """{file: [bytes that it contributes, {files that it includes}]} from the output of preprocess()."""
    files, by_name, skipped = {}, {}, []
    current, wanted = None, None
    for line in output.splitlines():
        if match := MARKER.match(line):
            file, flags = match.groups()
            if "1" in flags.split():
                files.setdefault(file, [0, set()])
                if wanted is not None:
                    by_name[wanted[1]] = file
                    files.get(wanted[0], [0, set()])[1].add(file)
                wanted = None
            current = file
        elif match := DIRECTIVE.match(line):
            skipped += [wanted] if wanted else []
            wanted = (current, match[1])
        elif line.strip() and current in files:
            files[current][0] += len(line) + 1
    # A header that was read before is not entered again: of it the directive has the name alone.
    for file, name in [*skipped, *([wanted] if wanted else [])]:
        if file in files and name in by_name:
            files[file][1].add(by_name[name])
    return files


def reach_of(files, header):
    """The header and all files that it includes, also through others."""
    seen, todo = set(), [header]
    while todo:
        file = todo.pop()
        if file not in seen and file in files:
            seen.add(file)
            todo += files[file][1]
    return seen


def read_bounds(file):
    """{room: largest size in kB} from a file of lines `room kB`; # begins a comment."""
    lines = (line.split("#")[0].split() for line in file.read_text(encoding="utf-8").splitlines())
    return {words[0]: int(words[1]) for words in lines if words}


def errors_of(files, headers, bounds):
    """Sentences about `headers`, {file as the preprocessor names it: path in the project}."""
    errors = []
    for file, path in headers.items():
        room, reach = room_of(path), reach_of(files, file)
        size = sum(files[one][0] for one in reach) // KB
        if not reach:
            errors.append(f"{path}: the preprocessor has not read it")
        elif size > bounds.get(room, 0):
            errors.append(f"{path}: {size} kB when preprocessed, at most {bounds.get(room, 0)} kB for a header of {room}: "
                          "declare types instead of including them, or move what needs them into a source")
        for library in (name for name, folder in HEAVY.items() if any(folder in one for one in reach)):
            errors.append(f"{path}: includes {library}, also through others; include it in sources alone")
    return errors


def check(root, bounds_file, compiler, generated):
    headers = public_headers(root)
    try:
        output = preprocess(compiler, root, headers, generated)
    except (OSError, RuntimeError) as reason:
        return [str(reason)]
    return errors_of(files_of(output), {str(header): header.relative_to(root) for header in headers}, read_bounds(bounds_file))
