"""The Debian packages: made from the build tree, complete, and without an error of lintian's."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD = pathlib.Path(sys.argv.pop(1))
PATIENCE_S = 240

if not all(map(shutil.which, ("cpack", "dpkg-deb", "dpkg-shlibdeps"))):
    print("cpack or Debian's packaging tools are not installed")
    sys.exit(77)


def output_of(*command):
    return subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=PATIENCE_S, check=True).stdout


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="driveline-packages-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        result = subprocess.run(["cpack", "-G", "DEB", "-B", str(cls.folder)], cwd=BUILD, capture_output=True, text=True,
                                timeout=PATIENCE_S, check=False)
        if result.returncode != 0:
            raise AssertionError(result.stdout + result.stderr)
        cls.packages = {file.name.split("_")[0]: file for file in cls.folder.glob("*.deb")}

    def field(self, package, name):
        return output_of("dpkg-deb", "-f", self.packages[package], name).strip()

    def files(self, package):
        return {line.split()[-1].removeprefix(".") for line in output_of("dpkg-deb", "-c", self.packages[package]).splitlines()
                if not line.startswith("d")}

    def test_each_holds_what_it_is_for(self):
        self.assertLessEqual({"driveline", "libdriveline-dev"}, set(self.packages))
        program = self.files("driveline")
        self.assertLessEqual({"/usr/bin/driveline", "/usr/lib/systemd/system/driveline@.service",
                              "/usr/lib/udev/rules.d/60-driveline.rules", "/usr/share/man/man1/driveline-run.1.gz",
                              "/usr/share/bash-completion/completions/driveline",
                              "/usr/share/zsh/site-functions/_driveline", "/usr/share/driveline/examples/line8.toml",
                              "/usr/share/doc/driveline/copyright"}, program)
        library = self.files("libdriveline-dev")
        self.assertIn("/usr/include/driveline/runtime/line.hpp", library)
        self.assertTrue(any(file.endswith("/drivelineConfig.cmake") for file in library))
        names = list(self.packages)
        for i, one in enumerate(names):
            for other in names[i + 1:]:
                self.assertEqual(self.files(one) & self.files(other), set(), f"{one}, {other}")
        for package in names:
            for file in self.files(package):
                self.assertRegex(file, "^/usr/(bin|lib|libexec|share|include)/", package)

    def test_the_real_time_program_does_not_depend_on_dds(self):
        self.assertNotIn("fastrtps", self.field("driveline", "Depends"))
        if "driveline-bridge" in self.packages:
            self.assertIn("fastrtps", self.field("driveline-bridge", "Depends"))
            self.assertLessEqual({"/usr/libexec/driveline/driveline-bridge", "/usr/libexec/driveline/driveline-dds",
                                  "/usr/lib/systemd/system/driveline-bridge@.service"},
                                 self.files("driveline-bridge"))

    def test_the_unit_names_the_place_of_the_package(self):
        with tempfile.TemporaryDirectory() as folder:
            output_of("dpkg-deb", "-x", self.packages["driveline"], folder)
            unit = pathlib.Path(folder, "usr/lib/systemd/system/driveline@.service").read_text(encoding="utf-8")
            self.assertIn("\nExecStart=/usr/bin/driveline run ", unit)
            version = output_of(f"{folder}/usr/bin/driveline", "--version")
        self.assertTrue(version.startswith(self.field("driveline", "Version").split("-")[0] + " ("), version)

    @unittest.skipUnless(shutil.which("lintian"), "lintian is not installed")
    def test_lintian_finds_no_error(self):
        result = subprocess.run(["lintian", "--allow-root", "--fail-on", "error", *map(str, self.packages.values())],
                                capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
