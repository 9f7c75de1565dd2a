"""The process image of a line description: groups, names and copies, in process and on the wire; cycles that cannot fit."""
import unittest

from program import EXAMPLES, ProgramTest, WireTest, again_when_disturbed, patient

EXAMPLE = EXAMPLES / "process_data.toml"


def last_line(result):
    """The sentence that a run ends with, behind what it says of its progress."""
    return result.stderr.splitlines()[-1]


class InProcess(ProgramTest):
    def test_run_tells_how_each_group_did(self):
        result = self.run_program("run", "--config", EXAMPLE, "--virtual", "--duration", 1, "--json", "--no-plots",
                                  "--no-telemetry")
        self.assertEqual(result.returncode, 0, result.stderr)
        image = self.one_document(result.stdout)["process_data"]
        self.assertEqual(image["layout"], "overlapped")
        groups = {group["name"]: group for group in image["groups"]}
        self.assertEqual(set(groups), {"others", "terminals", "slow"})
        self.assertGreater(groups["others"]["exchanges"], 4000)
        for name, divider in (("terminals", 4), ("slow", 40)):
            self.assertEqual(groups[name]["divider"], divider)
            self.assertLessEqual(abs(groups[name]["exchanges"] - groups["others"]["exchanges"] // divider), 1)
        self.assertEqual([group["wkc_errors"] for group in image["groups"]], [0, 0, 0])
        self.assertTrue(0 < image["wire_utilisation"] < 0.5)

    def test_pdos_shows_the_image(self):
        result = self.run_program("pdos", "--config", EXAMPLE, "--image")
        self.assertEqual(result.returncode, 0, result.stderr)
        for part in ("group terminals", "every 40 cycles from 2", "outputs.lamp", "x.Position actual value",
                     "frame 0  LWR", "copy    inputs.Channel 1/Input -> outputs.lamp, 1 bits"):
            self.assertIn(part, result.stdout)
        document = self.one_document(self.run_program("pdos", "--config", EXAMPLE, "--image", "--json").stdout)
        self.assertEqual(sum(row["working_counter"] for row in document["datagram_list"]), 10)
        self.assertIn("analogue.Channel 2/Value", [entry["name"] for entry in document["entries"]])

    def test_wrong_names_are_wrong_configuration(self):
        text = EXAMPLE.read_text().replace('"outputs.lamp"', '"outputs.horn"')
        for key in ("terminals.xml", "process_data.csv"):
            text = text.replace(f'"{key}"', f'"{EXAMPLES / key}"')
        config = self.write("line.toml", text)
        line = 1 + text[:text.index('"outputs.horn"')].count("\n")
        for command in (["run", "--virtual"], ["pdos", "--image"]):
            result = self.run_program(*command, "--config", config)
            self.assertEqual(result.returncode, 2, result.stderr)
            for part in (f"line.toml:{line}: [copy 1] to: there is no process variable 'outputs.horn'",
                         "outputs.7000h:01 (Channel 1/Output)"):
                self.assertIn(part, last_line(result))
            self.assertEqual(result.stdout, "")
        self.check_refused(self.run_program("pdos", "--image", "--iface", "lo"), 2, "--config FILE is missing")
        self.check_refused(self.run_program("pdos", "--image", "--config", EXAMPLE, "-p", "1"), 2, "--image")


class OnTheWire(WireTest):
    @again_when_disturbed
    def test_groups_and_copies_run_over_an_interface(self):
        text = EXAMPLE.read_text().replace("cycle_us = 250", "cycle_us = 2000") + "plots = false\n"
        text += '[realtime]\npolicy = "degrade"\n[bus]\n'
        for key in ("terminals.xml", "process_data.csv"):
            text = text.replace(f'"{key}"', f'"{EXAMPLES / key}"')
        config = self.write("line.toml", patient(text))
        self.start_line(config)
        result = self.run_program("run", "--config", config, "--iface", "dl-master", "--duration", 2, "--json",
                                  "--no-plots", "--no-telemetry")
        self.write("run.log", result.stderr)
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual((document["state"], document["wkc_errors"], document["faults"]), ("OP", 0, []))
        self.assertTrue(document["process_data"]["wire_line_measured"])
        self.assertGreater(document["process_data"]["groups"][1]["exchanges"], 100)

    def test_a_cycle_that_cannot_fit_is_refused_with_the_numbers(self):
        slaves = "".join(f'[[slave]]\nname = "s{i}"\n' for i in range(130))
        config = self.write("line.toml", f'{slaves}[line]\ncycle_us = 125\n[realtime]\npolicy = "degrade"\n')
        self.start_line(config)
        result = self.run_program("run", "--config", config, "--iface", "dl-master", "--duration", 1, "--no-plots",
                                  "--no-telemetry")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(last_line(result), r"arrives after 1\d\d\.\d us \(\d+\.\d us of frames at 100 Mbit/s and 1\d\d\.\d us "
                                            r"through the line\), but a cycle of 125\.0 us waits 93\.8 us")
        self.assertEqual(result.stdout, "")

    def test_an_answer_behind_the_window_is_refused_though_it_is_within_the_period(self):
        slaves = "".join(f'[[slave]]\nname = "s{i}"\n' for i in range(8))
        config = self.write("line.toml", f'{slaves}[line]\ncycle_us = 125\n[realtime]\npolicy = "degrade"\n'
                                         '[wiring]\npreset = "line"\ncable_m = 1150\n')
        self.start_line(config)
        result = self.run_program("run", "--config", config, "--iface", "dl-master", "--duration", 1, "--no-plots",
                                  "--no-telemetry")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(last_line(result), r"arrives after (9[4-9]|1[01]\d)\.\d us .* waits 93\.8 us")
        self.assertNotIn("all in OP", result.stderr)


class BudgetInProcess(ProgramTest):
    def run_line(self, slaves, *parts):
        text = "".join(f'[[slave]]\nname = "s{i}"\n' for i in range(slaves))
        config = self.write("line.toml", f'{text}[line]\ncycle_us = 125\n' + "".join(parts))
        return self.run_program("run", "--config", config, "--virtual", "--duration", 0.2, "--no-plots", "--no-telemetry")

    def test_a_line_that_is_longer_than_the_cycle_waits_is_refused(self):
        result = self.run_line(130)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(last_line(result), r"arrives after 1\d\d\.\d us \(1\d\d\.\d us through the line\), but a cycle")

    def test_frames_that_all_come_too_late_keep_the_line_in_safeop(self):
        # The delay to the first slave is in no receive time.
        result = self.run_line(1, '[wiring]\npreset = "line"\ncable_m = 10000\n')
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(last_line(result), r"no cyclic frame returned within the 93 us of waiting per cycle, in \d+ cycles; \d+ frames came later")
        self.assertNotIn("all in OP", result.stderr)

    def test_a_wire_that_would_be_too_slow_is_told(self):
        result = self.run_line(88)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("at 100 Mbit/s the answers would not return within 93.8 us", result.stderr)


if __name__ == "__main__":
    unittest.main()
