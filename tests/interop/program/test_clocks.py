"""Distributed clocks as users of the program meet them."""
import unittest

from program import EXAMPLES, ProgramTest

LINE = EXAMPLES / "line8-dc.toml"


class Clocks(ProgramTest):
    def test_a_run_is_locked_and_says_how_well(self):
        result = self.run_program("run", "--config", LINE, "--virtual", "--duration", 2, "--json", "--no-telemetry",
                                  "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual(document["state"], "OP")
        self.assertTrue(document["dc"]["locked"])
        self.assertLessEqual(document["dc"]["difference_ns"]["max"], 200)
        self.assertEqual(document["faults"], [])

    def test_the_table_shows_every_clock(self):
        result = self.run_program("dc", "--config", LINE, "--virtual", "--duration", 1, "--output", "figures")
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = [line.split() for line in result.stdout.splitlines()[1:9]]
        self.assertEqual([row[1] for row in rows], ["x", "y", "z", "a", "b", "c", "u", "v"])
        self.assertEqual([row[4] for row in rows].count("*"), 1)
        self.assertIn("locked to the reference clock", result.stdout)
        lines = self.text("figures/clocks.csv").splitlines()
        self.assertGreater(len(lines), 150)
        self.assertTrue(all(line.count(",") == 8 for line in lines))

    def test_the_document_has_delays_that_grow_along_the_line(self):
        result = self.run_program("dc", "--config", LINE, "--virtual", "--duration", 1, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertTrue(document["locked"])
        self.assertAlmostEqual(document["ppm"], 12.0, delta=0.5)
        delays = [slave["delay_ns"] for slave in document["slaves"]]
        self.assertEqual(delays, [505 * i for i in range(8)])
        self.assertTrue(all(slave["sync0_cycle_ns"] == 125000 for slave in document["slaves"]))

    def test_a_wrong_shift_is_one_sentence(self):
        text = LINE.read_text(encoding="utf-8").replace("drift_ppm = 12.0", "sync0_shift_us = 125")
        path = self.write("line.toml", text.replace('"line8.csv"', f'"{EXAMPLES / "line8.csv"}"'))
        result = self.run_program("run", "--config", path, "--virtual", "--no-plots", "--no-telemetry")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("slave 0: the SYNC0 shift of 125000 ns is not shorter than the SYNC0 cycle of 125000 ns",
                      result.stderr)


if __name__ == "__main__":
    unittest.main()
