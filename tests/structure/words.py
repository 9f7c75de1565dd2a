"""What the documents promise: links that lead somewhere, a page per room, proofs that exist."""
import re

from rooms import FOLDERS

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
    plain = (re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in HEADING.findall(text))
    return set(plain)


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
    return [f"room {folder} has no README.md" for folder in FOLDERS if not (root / folder / "README.md").is_file()]


TEST_CASE = re.compile(r"\b(?:TYPED_TEST(?:_P)?|TEST(?:_F|_P)?|RC_GTEST_(?:FIXTURE_)?PROP)\s*\(\s*(\w+)\s*,\s*(\w+)")
CMAKE_TEST = re.compile(r"\b(?:add_test\s*\(\s*NAME|driveline_test\s*\(|driveline_bench\s*\()\s*([\w.\-]+)")


def known_proofs(root):
    """Everything a row may name: test cases `Suite.Name`, suites, and the names of tests and benches in CMake."""
    proofs = set()
    for top in ("tests", "bench"):
        for path in (root / top).rglob("*"):
            if path.suffix == ".cpp":
                for suite, name in TEST_CASE.findall(path.read_text(encoding="utf-8")):
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


def check(root):
    return link_errors(root) + readme_errors(root) + feature_errors(root)
