"""Modules of the npm registry for a test, as its package-lock.json names them by version and checksum."""
import pathlib
import shutil
import subprocess
import unittest

from program import DRIVELINE, PATIENCE_S, ROOT


def install(test, what):
    """Installs the modules of tests/interop/<test> in the build tree and returns their folder; `what` is their name in messages."""
    sources = ROOT / "tests/interop" / test
    folder = pathlib.Path(DRIVELINE).parent / "tests/interop" / test
    lock = (sources / "package-lock.json").read_text(encoding="utf-8")
    if not shutil.which("node"):
        raise unittest.SkipTest("node is not installed (Debian package nodejs)")
    done = folder / "installed"
    if done.is_file() and done.read_text(encoding="utf-8") == lock:
        return folder
    if not shutil.which("npm"):
        raise unittest.SkipTest(f"{what} is not installed, and there is no npm to get it (Debian package npm)")
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("package.json", "package-lock.json"):
        shutil.copy(sources / name, folder)
    try:
        result = subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=folder, capture_output=True, text=True,
                                timeout=PATIENCE_S, check=False)
    except subprocess.TimeoutExpired as late:
        raise unittest.SkipTest(f"{what} is not installed, and npm does not reach its registry in time") from late
    if result.returncode != 0:
        if "EINTEGRITY" in result.stderr:
            raise AssertionError(result.stderr)
        raise unittest.SkipTest(f"{what} is not installed, and npm cannot get it: {result.stderr.strip().splitlines()[-1]}")
    done.write_text(lock, encoding="utf-8")
    return folder
