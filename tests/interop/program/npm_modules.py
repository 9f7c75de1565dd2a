"""Modules of the npm registry for a test, as its package-lock.json names them by version and checksum."""
import fcntl
import os
import pathlib
import shutil
import subprocess
import unittest

from program import DRIVELINE, PATIENCE_S, ROOT


def lacking(reason):
    """What to raise where the modules cannot be had: a failure where DRIVELINE_NPM is `required`, as in .ci/run."""
    return AssertionError(reason) if os.environ.get("DRIVELINE_NPM") == "required" else unittest.SkipTest(reason)


def install(test, what):
    """Installs the modules of tests/interop/<test> in the build tree and returns their folder; `what` is their name in messages."""
    sources = ROOT / "tests/interop" / test
    folder = pathlib.Path(DRIVELINE).parent / "tests/interop" / test
    lock = (sources / "package-lock.json").read_text(encoding="utf-8")
    if not shutil.which("node"):
        raise lacking("node is not installed (Debian package nodejs)")
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "lock", "w", encoding="utf-8") as lock_file:  # tests run at the same time
        fcntl.flock(lock_file, fcntl.LOCK_EX)
        return install_locked(sources, folder, lock, what)


def install_locked(sources, folder, lock, what):
    """What install() does while nobody else does it."""
    done = folder / "installed"
    if done.is_file() and done.read_text(encoding="utf-8") == lock:
        return folder
    if not shutil.which("npm"):
        raise lacking(f"{what} is not installed, and there is no npm to get it (Debian package npm)")
    for name in ("package.json", "package-lock.json"):
        shutil.copy(sources / name, folder)
    try:
        result = subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=folder, capture_output=True, text=True,
                                timeout=PATIENCE_S, check=False)
    except subprocess.TimeoutExpired as late:
        raise lacking(f"{what} is not installed, and npm does not reach its registry in time") from late
    if result.returncode != 0:
        if "EINTEGRITY" in result.stderr:
            raise AssertionError(result.stderr)
        raise lacking(f"{what} is not installed, and npm cannot get it: {result.stderr.strip().splitlines()[-1]}")
    done.write_text(lock, encoding="utf-8")
    return folder


def write_sheet(test, name):
    """Writes the electronic data sheet `name` of the simulated drives into the folder of the test, without the parameters that
    have data at sub-index 0, which the module canopen takes for the number of entries. Returns its path."""
    test.assertEqual(test.run_program("esi", "generate", test.directory).returncode, 0)
    first, *sections = (test.directory / name).read_text(encoding="utf-8").split("\n[")
    with_data = {section[:4] for section in sections if section[4:9] == "sub0]" and "DataType=0x0005\n" not in section}
    test.assertGreater(len(with_data), 3)
    kept = [section for section in sections if section[:4] not in with_data]
    test.assertGreater(len(kept), 200)
    return test.write("sheet.eds", "\n[".join([first, *kept]))
