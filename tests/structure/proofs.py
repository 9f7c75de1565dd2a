"""Whether every test that the feature and drive pages name for a proof has run and passed, by what ctest says of its run."""
import re
import xml.etree.ElementTree as ElementTree

PAGES = ("docs/features.md", "docs/msd.md", "docs/servoone.md", "docs/sercos.md", "docs/mc7000.md",
         "docs/position_servo.md", "docs/canopen.md")
# Reasons for which a test may skip: the machine lacks something. With any other reason the test counts as switched off.
LACKS = re.compile(r"not permitted|[Pp]ermission denied|no permission|no veth pair|no network namespace|no TAP interfaces|only root|"
                   r"kernel refuses|real-time priority|can neither give up|no file system of its own|cannot be opened|"
                   r"/dev/cpu_dma_latency|one CPU only|is not installed|is not in .*DRIVELINE_CAPTURES|built with DRIVELINE_")


def proofs(root):
    """(page, line, name) for every name in a column for proofs: of rows that are supported, in part, or proven."""
    for page in (page for page in PAGES if (root / page).is_file()):
        column = None
        for number, line in enumerate((root / page).read_text(encoding="utf-8").splitlines(), 1):
            cells = [cell.strip() for cell in line.strip().strip("|").split("|")] if line.startswith("|") else []
            heads = [i for i, cell in enumerate(cells) if cell in ("proof", "test") or cell.startswith("test, or ")]
            if not cells or heads:
                column = heads[0] if heads else None
            elif column is not None and column < len(cells) and not {"Planned", "open"} & set(cells):
                yield from ((page, number, name) for name in re.findall(r"`([^`]+)`", cells[column]))


def outcomes(junits):
    """{name: (status, reasons)} of the tests in all result files. Of several results a failure counts most, then a pass.

    Status: `run` passed, `fail`, `disabled`, `notrun` skipped."""
    order = ("fail", "run")  # any other status counts least
    by_test = {}
    for junit in junits:
        for case in ElementTree.parse(junit).getroot().iter("testcase"):
            outcome = (case.get("status"), skip_reasons(case.findtext("system-out") or ""))
            before = by_test.get(case.get("name"))
            rank = [order.index(one[0]) if one and one[0] in order else len(order) for one in (outcome, before)]
            if before is None or rank[0] < rank[1]:
                by_test[case.get("name")] = outcome
    return by_test


def results(junits):
    """The results of ctest by every name that a row may use for a test: a list of (status, reasons) each."""
    by_name = {}
    for test, outcome in outcomes(junits).items():
        for name in names_of(test.partition("  # ")[0]):
            by_name.setdefault(name, []).append(outcome)
    return by_name


def skipped(junits):
    """A sentence for each test that did not run, with the reason that it gives."""
    for test, (status, reasons) in outcomes(junits).items():
        if status not in ("run", "fail"):
            yield f"not run: {test}: " + ("; ".join(reasons) or f"no reason given ({status})")


def names_of(test):
    """`Line/Suite.Case/3`, a test with a parameter or a type, goes by Suite, Suite.* and Suite.Case."""
    head, dot, tail = test.partition(".")
    names = {test}
    for suite in head.split("/") if dot else ():
        names |= {suite, f"{suite}.*", f"{suite}.{tail.partition('/')[0]}"}
    return names


def skip_reasons(output):
    """GoogleTest puts the reason below the place, run_tests.py behind the test."""
    return re.findall(r": Skipped\n(.+)", output) + re.findall(r"(?m)^SKIPPED: .*", output) + \
        re.findall(r"(?m)^.* is not installed; .*", output)


def errors_and_gaps(root, junits, build, left_out=""):
    """Sentences about proofs that are none, and about those that this machine could not run. `left_out`: tests that
    this run leaves to .ci/run, as a regular expression."""
    ran = results(junits)
    errors = []
    gaps = []
    for page, number, name in proofs(root):
        test = re.sub(r"^tests/fuzz/fuzz_(\w+)$", r"fuzz.\1.replay", name)
        if test not in ran and left_out and re.fullmatch(left_out, test):
            gaps.append(f"{page}:{number}: {name} is left to .ci/run")
            continue
        if test not in ran:
            if not (build / "bench" / name.removeprefix("bench/")).is_file():
                errors.append(f"{page}:{number}: {name} has not run: no such test, or it is not compiled")
            continue
        for status, reasons in ran[test]:
            if status == "notrun" and reasons and all(map(LACKS.search, reasons)):
                gaps.append(f"{page}:{number}: {name} is not proven on this machine: {reasons[0]}")
            elif status != "run":
                state = {"notrun": "was skipped", "disabled": "is disabled", "fail": "failed"}.get(status, f"is '{status}'")
                errors.append(f"{page}:{number}: {name} {state}" + "".join(f": {reason}" for reason in reasons[:1]))
    return list(dict.fromkeys(errors)), list(dict.fromkeys(gaps))
