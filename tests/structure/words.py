"""Checks of the documents: links that lead somewhere, a page per room, proofs that exist."""
import collections
import re

from rooms import FOLDERS, code_only, sources

LINK = re.compile(r"!?\[[^\]]*\]\(\s*<?([^)\s>]+)>?[^)]*\)")
HEADING = re.compile(r"^#+\s+(.*?)\s*#*$", re.M)


def documents(root):
    """Markdown files of the project, outside build folders and hidden ones."""
    return sorted(
        path.relative_to(root)
        for path in root.rglob("*.md")
        if not any(part.startswith((".", "build")) or part == "out" for part in path.relative_to(root).parts)
    )


def without_code(text):
    return re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.S)


def anchors(text):
    """Anchors of the headings, formed as the usual forges form them."""
    found = set()
    seen = collections.Counter()
    for heading in HEADING.findall(text):
        plain = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        # One that is there already gets a number.
        found.add(f"{plain}-{seen[plain]}" if seen[plain] else plain)
        seen[plain] += 1
    return found


def link_errors(root):
    errors = []
    for document in documents(root):
        text = (root / document).read_text(encoding="utf-8")
        for link in LINK.findall(without_code(text)):
            if re.match(r"[a-z][a-z0-9+.-]*:", link):
                continue
            target, _, anchor = link.partition("#")
            file = (root / document).parent / target if target else root / document
            if not file.exists():
                errors.append(f"{document} links to {link}, which does not exist")
            elif anchor and file.suffix == ".md" and anchor not in anchors(file.read_text(encoding="utf-8")):
                errors.append(f"{document} links to {link}, but that page has no such heading")
    return errors


def readme_errors(root):
    rooms = [folder for folder in FOLDERS if not folder.startswith("tests/")]
    return [f"room {folder} has no README.md" for folder in rooms if not (root / folder / "README.md").is_file()]


TEST_CASE = re.compile(r"\b(?:TYPED_TEST(?:_P)?|TEST(?:_F|_P)?|RC_GTEST_(?:FIXTURE_)?PROP)\s*\(\s*(\w+)\s*,\s*(\w+)")
CMAKE_TEST = re.compile(r"\b(?:add_test\s*\(\s*NAME|driveline_test\s*\(|driveline_bench\s*\()\s*([\w.\-]+)")


def known_proofs(root):
    """Everything a row may name: test cases `Suite.Name`, suites, and the names of tests and benches in CMake."""
    proofs = set()
    for top in ("tests", "bench", "examples"):
        for path in (root / top).rglob("*"):
            if path.suffix == ".cpp":
                for suite, name in TEST_CASE.findall(code_only(path.read_text(encoding="utf-8"))):
                    proofs |= {suite, f"{suite}.*", f"{suite}.{name}"}
            elif path.name == "CMakeLists.txt":
                proofs |= set(CMAKE_TEST.findall(path.read_text(encoding="utf-8")))
    return proofs


def is_proof(root, proofs, name):
    """A known name, or the path of a test or bench source (with or without .cpp)."""
    if name in proofs:
        return True
    in_place = name.startswith(("tests/", "bench/"))
    return in_place and any((root / (name + suffix)).is_file() for suffix in ("", ".cpp"))


def feature_errors(root):
    page = "docs/features.md"
    proofs = known_proofs(root)
    errors = []
    for number, line in enumerate((root / page).read_text(encoding="utf-8").splitlines(), 1):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|") or "Supported" not in cells:
            continue
        status = cells.index("Supported")
        named = re.findall(r"`([^`]+)`", cells[status + 1]) if status + 1 < len(cells) else []
        feature = cells[status - 1]
        if not named:
            errors.append(f"{page}:{number}: '{feature}' is Supported but names no test or bench")
        errors += [f"{page}:{number}: '{feature}' names {name}, which is no test or bench"
                   for name in named if not is_proof(root, proofs, name)]
    return errors


TEST_HEAD = re.compile(r"\bTEST(?:_F|_P)?\s*\(\s*(\w+)\s*,\s*(\w+)\s*\)")


def running_tests(root):
    """Test cases that run in every build: in a source that a test program lists, neither disabled nor skipping."""
    running = set()
    for folder in {path.parent for path in (root / "tests").rglob("*.cpp")}:
        cmake = folder / "CMakeLists.txt"
        listed = set(re.findall(r"[\w]+\.cpp", cmake.read_text(encoding="utf-8"))) if cmake.is_file() else set()
        for path in folder.glob("*.cpp"):
            if path.name not in listed:
                continue
            text = code_only(path.read_text(encoding="utf-8"))
            heads = list(TEST_HEAD.finditer(text))
            for head, end in zip(heads, [h.start() for h in heads[1:]] + [len(text)]):
                suite, name = head.groups()
                if name.startswith("DISABLED_") or suite.startswith("DISABLED_") or "GTEST_SKIP" in text[head.end():end]:
                    continue
                running.add(f"{suite}.{name}")
    programs = root / "tests/interop/program/CMakeLists.txt"
    if programs.is_file():
        running.update(re.findall(r"add_test\(NAME (program\.\w+)", programs.read_text(encoding="utf-8")))
    return running


# Pages that list the facts of a manual.
CHECKLISTS = ("docs/msd.md", "docs/servoone.md", "docs/sercos.md", "docs/mc7000.md", "docs/position_servo.md")


def checklist_errors(root):
    """A proven row of a checklist names tests that run, an open one says why."""
    pages = [page for page in CHECKLISTS if (root / page).is_file()]
    running = running_tests(root) if pages else set()
    return [error for page in pages for error in page_errors(root, page, running)]


def page_errors(root, page, running):
    errors = []
    for number, line in enumerate((root / page).read_text(encoding="utf-8").splitlines(), 1):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|") or not cells[0].isdigit():
            continue
        if len(cells) != 5 or cells[4] not in ("proven", "open"):
            errors.append(f"{page}:{number}: a row has five cells and ends in proven or open")
            continue
        named = re.findall(r"`([^`]+)`", cells[3])
        if not cells[3] or (cells[4] == "proven" and not named):
            errors.append(f"{page}:{number}: fact {cells[0]} is {cells[4]} but says neither test nor reason")
        if cells[4] == "proven":
            errors += [f"{page}:{number}: fact {cells[0]} names {name}, which is no test that runs"
                       for name in named if name not in running]
    return errors


# What a concept is not called, and what it is.
TERMS = {re.compile(r"\bline files?\b", re.I): "line description"}


def term_errors(root):
    """Second words for one concept, in documents and in sources with their comments."""
    errors = []
    for path in [*documents(root), *sources(root)]:
        for number, line in enumerate((root / path).read_text(encoding="utf-8").splitlines(), 1):
            errors += [f"{path}:{number}: \"{found[0]}\" is called {term}" for word, term in TERMS.items()
                       if (found := word.search(line))]
    return errors


def check(root):
    return link_errors(root) + readme_errors(root) + feature_errors(root) + checklist_errors(root) + term_errors(root)
