"""Help, the examples in it, and shell completion: all three come from the table of commands."""
import pathlib
import re
import shlex
import shutil
import subprocess
import unittest

from program import DRIVELINE, PATIENCE_S, ROOT, ProgramTest, shortened

# Where this process should see what a user in the folder of the project sees.
FOLDERS = ("examples", "esi")


def run(*arguments):
    return subprocess.run([DRIVELINE, *arguments], capture_output=True, text=True, timeout=PATIENCE_S, check=False)


def listed(text):
    """Commands under the headings of a help text."""
    return re.findall(r"^  ([a-z_]+) {2,}\S", text, re.M)


def all_commands():
    """Every command as a list of words, groups resolved."""
    found = []
    for name in listed(run("--help").stdout):
        members = listed(run(name, "--help").stdout)
        found += [[name, member] for member in members] if members else [[name]]
    return found


def examples(command):
    text = run(*command, "--help").stdout.partition("Examples:\n")[2]
    return [shlex.split(line)[1:] for line in text.splitlines() if line.strip().startswith("driveline ")]


class Help(ProgramTest):
    def setUp(self):
        super().setUp()
        for folder in FOLDERS:
            (self.directory / folder).symlink_to(ROOT / folder)

    def test_every_command_shows_examples_that_work(self):
        commands = all_commands()
        self.assertGreater(len(commands), 8)
        tried = 0
        for command in commands:
            shown = examples(command)
            self.assertTrue(shown, command)
            for arguments in shown:
                with self.subTest(command=" ".join(arguments)):
                    self.assertEqual(arguments[:len(command)], command)
                    if "--iface" in arguments or "--control" in arguments or "--slcan" in arguments:
                        continue  # of a line that is served; tried with the documents, and in test_can
                    if command in (["axis"], ["echo"], ["fault"], ["group"], ["input"], ["plot"], ["record"], ["top"]):
                        continue  # they want a line that runs; see test_by_hand, test_groups and test_clients
                    if command == ["bench"] and not (pathlib.Path(DRIVELINE).parent / "bench").is_dir():
                        continue  # built without benchmarks
                    if ">" in arguments:
                        arguments = arguments[:arguments.index(">")]
                    result = self.run_undisturbed(*shortened(arguments))
                    self.assertEqual(result.returncode, 0, result.stderr)
                    if "--json" in arguments:
                        self.one_document(result.stdout)
                    tried += 1
        self.assertGreater(tried, len(commands) / 2)

    def test_complaints_name_the_command_and_its_help(self):
        result = run("upload", "--config", "examples/line8.toml")
        self.assertEqual((result.returncode, result.stdout), (2, ""))
        self.assertRegex(result.stderr, r"\Adriveline upload: .*INDEX.*driveline upload --help shows more\n\Z")
        result = run("esi", "show", "a.xml", "--colour")
        self.assertEqual((result.returncode, result.stdout), (2, ""))
        self.assertRegex(result.stderr, r"\Adriveline esi show: .*--colour.*driveline esi show --help shows more\n\Z")


class Completion(ProgramTest):
    def complete(self, *words):
        """What bash offers for the last of the words behind `driveline`."""
        script = self.write("completion.bash", run("completion", "bash").stdout)
        quoted = " ".join(shlex.quote(word) for word in ("driveline", *words))
        source = (f"source {shlex.quote(str(script))}; COMP_WORDS=({quoted}); COMP_CWORD={len(words)}; _driveline; "
                  'printf "%s\\n" "${COMPREPLY[@]}"')
        result = subprocess.run(["bash", "--norc", "-u", "-c", source], cwd=self.directory, capture_output=True,
                                text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return result.stdout.split()

    def test_commands(self):
        self.assertEqual(set(self.complete("")) - {"--help", "--version"}, set(listed(run("--help").stdout)))
        self.assertEqual(self.complete("upl"), ["upload"])
        self.assertEqual(self.complete("esi", "v"), ["validate"])

    def test_every_option_of_every_command(self):
        for command in all_commands():
            with self.subTest(command=command):
                text = run(*command, "--help").stdout
                known = set(re.findall(r"(?<![\w-])(--[a-z0-9-]+)", text.partition("Options:")[2].partition("Examples:")[0]))
                offered = {word for word in self.complete(*command, "-") if word.startswith("--")}
                self.assertEqual(offered, known)

    def test_values(self):
        self.write("line.toml", "")
        self.assertEqual(self.complete("slaves", "--config", "li"), ["line.toml"])
        self.assertEqual(self.complete("slaves", "--iface", "l"), ["lo"])
        self.assertEqual(self.complete("upload", "-t", "uint3"), ["uint32"])
        self.assertEqual(self.complete("states", "SA"), ["SAFEOP"])
        self.assertEqual(self.complete("upload", "-p", ""), [])

    def zsh(self, *words):
        """What the completion functions of zsh are told for the last of the words behind `driveline`."""
        script = self.write("_driveline", run("completion", "zsh").stdout)
        quoted = " ".join(shlex.quote(word) for word in ("driveline", *words))
        source = ("_arguments() { print -rl -- \"$@\" }; _describe() { print -rl -- ${(P)2} }; compdef() { }; "
                  f"source {shlex.quote(str(script))}; words=({quoted}); CURRENT={len(words) + 1}; _driveline; "
                  "print -r -- \"at $CURRENT\"")
        result = subprocess.run(["zsh", "-f", "-c", source], cwd=self.directory, capture_output=True, text=True,
                                timeout=PATIENCE_S, check=False)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        return result.stdout.splitlines()

    @unittest.skipUnless(shutil.which("zsh"), "zsh is not installed")
    def test_zsh(self):
        names = {line.split(":")[0] for line in self.zsh("")}
        self.assertLessEqual(set(listed(run("--help").stdout)), names)
        self.assertIn("validate:Check an ESI file, EDS or DCF, and list what the reader ignores", self.zsh("esi", ""))
        self.assertIn("(-t --type)-t[uint8 ... int64, float, double, string, raw ...; default\\: the type in the slave's "
                      "dictionary]:TYPE:(" , "\n".join(self.zsh("upload", "-"))[:100000])
        self.assertIn(":STATE:(INIT PREOP SAFEOP BOOT)", "\n".join(self.zsh("states", "")))
        # _arguments counts from the last word of the command.
        self.assertEqual(self.zsh("sii", "read", "-")[-1], "at 2")
        for command in all_commands():
            with self.subTest(command=command):
                text = run(*command, "--help").stdout
                known = set(re.findall(r"(?<![\w-])(--[a-z0-9-]+)", text.partition("Options:")[2].partition("Examples:")[0]))
                offered = set(re.findall(r"(?m)^(?:\([^)]*\))?(--[a-z0-9-]+)\[", "\n".join(self.zsh(*command, "-"))))
                self.assertEqual(offered, known)

    def test_another_shell_is_refused(self):
        self.check_refused(run("completion", "tcsh"), 2, "tcsh", "bash")


if __name__ == "__main__":
    unittest.main()
