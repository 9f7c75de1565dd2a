"""Slaves that go and come back while the program runs the line, a ring that breaks, and the diagnosis of it all."""
import csv
import signal
import unittest

from program import AXES, DISTURBED, ProgramTest, RingTest, WireTest, again_when, again_when_disturbed

LAST = len(AXES) - 1


def fault(kind, at_ms, **keys):
    """A [[fault]] of the line description."""
    return f'[[fault]]\nat_ms = {at_ms}\nkind = "{kind}"\n' + "".join(f"{key} = {value}\n" for key, value in keys.items())


class InThisProcess(ProgramTest):
    def run_line(self, *faults, head="", duration=8):
        config = self.write_gentle_line(False, cycle_us=1000, head="[bus]\nmax_lost_cycles = 8\n" + head + "\n" + "".join(faults))
        result = self.run_program("run", "--config", config, "--virtual", "--duration", duration, "--json", "--no-plots")
        document = self.one_document(result.stdout) if result.stdout else None
        return result, document

    def check_back(self, document, slave):
        name = AXES[slave]
        text = "\n".join(document["events"])
        self.assertIn(f"slave {slave} ({name}): back in OP", text)
        for step in (f"axis {name}: unavailable", f"axis {name}: enabled, returning to the path",
                     f"axis {name}: back on the path"):
            self.assertIn(step, text)
        self.assertGreater(document["axes"][slave]["unavailable_cycles"], 0)

    def test_a_drive_that_is_switched_off_and_on(self):
        for policy, others in (("hold", "come to rest on the path and wait for it"), ("continue", "go on without it")):
            with self.subTest(policy=policy):
                result, document = self.run_line(fault("power-off", 3000, slave='"v"', for_ms=700),
                                                 head=f'[recovery]\naxes = "{policy}"')
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(document["state"], "OP")
                self.assertEqual(document["recoveries"], 1)
                self.assertEqual(document["faults"], [f"slave {LAST} (v): no longer answers",
                                                      f"axis v: unavailable; the others {others}"])
                self.check_back(document, LAST)
                for axis in document["axes"][:-1]:
                    self.assertEqual(axis["unavailable_cycles"], 0, axis)
                self.assertIn(f"fault: slave {LAST} (v): no longer answers", result.stderr)
                self.assertIn("axis v: back on the path", result.stderr)
                with open(self.directory / "out/flight_recorder.csv", encoding="utf-8") as file:
                    rows = list(csv.DictReader(file))
                self.assertEqual([row["v.available"] for row in (rows[0], rows[-1])], ["1", "0"])
                self.assertEqual({row["x.available"] for row in rows}, {"1"})

    def test_by_default_a_lost_drive_ends_the_run(self):
        result, document = self.run_line(fault("power-off", 3000, slave='"v"', for_ms=700))
        self.assertEqual(result.returncode, 1)
        self.assertIn(f"slave {LAST} (v): no longer answers", document["faults"])
        self.assertEqual(document["state"], "INCOMPLETE")
        self.assertEqual(document["recoveries"], 0)
        self.assertLess(document["duration_s"], 4)

    def test_a_cable_that_is_pulled_and_plugged_in(self):
        result, document = self.run_line(fault("cable-break", 3000, slave='"c"', to='"u"', for_ms=1000),
                                         head='[recovery]\naxes = "hold"')
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(document["recoveries"], 2)
        for slave in (LAST - 1, LAST):
            self.check_back(document, slave)

    def test_a_drive_that_falls_to_safeop(self):
        # Without outputs its watchdog fires.
        result, document = self.run_line(fault("short-wkc", 3000, slave='"v"', for_ms=400),
                                         head='[recovery]\naxes = "continue"')
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(f"slave {LAST} (v): left OP, is in SAFEOP with an error, AL status code 0x001B (sync manager "
                      "watchdog)", document["faults"])
        self.check_back(document, LAST)

    def test_the_whole_line_is_cut_off_for_a_while(self):
        result, document = self.run_line(fault("drop", 3000, for_ms=800), head='[recovery]\naxes = "hold"')
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue(any(text.startswith("communication lost") for text in document["faults"]), document["faults"])
        self.assertIn("frames return again", "\n".join(document["events"]))
        self.assertEqual(document["recoveries"], len(AXES))
        for slave in range(len(AXES)):
            self.check_back(document, slave)

    def test_patience_has_an_end(self):
        result, document = self.run_line(fault("power-off", 3000, slave='"v"'),
                                         head='[recovery]\naxes = "hold"\ngive_up_s = 2')
        self.assertEqual(result.returncode, 1)
        self.assertIn(f"slave {LAST} (v): not back within 2 s", document["faults"])
        result, document = self.run_line(fault("power-off", 3000, slave='"v"'), head='[recovery]\naxes = "continue"',
                                         duration=5)
        self.assertEqual(result.returncode, 1)
        self.assertIn(f"slave {LAST} (v): was not back when the run ended", document["faults"])

    def test_a_hot_connected_drive_joins_when_it_comes(self):
        for at_ms, for_ms in ((0, 3000), (0, 0)):
            with self.subTest(for_ms=for_ms):
                fault_of_v = fault("power-off", at_ms, slave='"v"', **({"for_ms": for_ms} if for_ms else {}))
                config = self.write_gentle_line(False, cycle_us=1000, head="[bus]\nmax_lost_cycles = 800\n" + fault_of_v)
                text = config.read_text(encoding="utf-8").replace('[[slave]]\nname = "v"\n',
                                                                  '[[slave]]\nname = "v"\nalias = 77\nhot_connect = true\n')
                config.write_text(text, encoding="utf-8")
                result = self.run_program("run", "--config", config, "--virtual", "--duration", 6, "--json", "--no-plots")
                self.assertEqual(result.returncode, 0, result.stderr)
                document = self.one_document(result.stdout)
                self.assertEqual(document["state"], "OP")
                self.assertEqual((document["wkc_errors"], document["lost_frames"]), (0, 0))
                events = "\n".join(document["events"])
                self.assertIn(f"slave {LAST} (v): is not connected; it joins the line when it is connected", events)
                for step in (f"slave {LAST} (v): joined the line and is in OP", "axis v: back on the path"):
                    self.assertEqual(step in events, bool(for_ms), events)
                for axis in document["axes"][:-1]:
                    self.assertEqual(axis["unavailable_cycles"], 0, axis)

    def test_a_hot_connected_group_joins_with_its_clocks_leaves_and_joins_again(self):
        faults = fault("power-off", 0, slave='"u"', for_ms=2500) + fault("power-off", 5000, slave='"u"', for_ms=500)
        config = self.write_gentle_line(False, cycle_us=1000, head="[bus]\nmax_lost_cycles = 800\n[dc]\n" + faults)
        text = config.read_text(encoding="utf-8")
        text = text.replace('[[slave]]\nname = "u"\n', '[[slave]]\nname = "u"\ndevice_id = 12\nhot_connect = true\n'
                            '[slave.dc]\ndrift_ppm = 60\n')
        text = text.replace('[[slave]]\nname = "v"\n', '[[slave]]\nname = "v"\nhot_connect = "u"\n[slave.dc]\ndrift_ppm = -40\n')
        config.write_text(text, encoding="utf-8")
        result = self.run_program("run", "--config", config, "--virtual", "--duration", 9, "--json", "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual(document["state"], "OP")
        events = "\n".join(document["events"])
        for slave, name in ((LAST - 1, "u"), (LAST, "v")):
            for step in (f"slave {slave} ({name}): is not connected; it joins the line when it is connected",
                         f"slave {slave} ({name}): joined the line and is in OP", f"axis {name}: back on the path",
                         f"slave {slave} ({name}): no longer answers", f"slave {slave} ({name}): back in OP"):
                self.assertIn(step, events)
        self.assertTrue(document["dc"]["locked"])
        # 60 ppm apart they would be 60 us off after a second.
        self.assertLess(document["dc"]["difference_ns"]["p99"], 200)
        for axis in document["axes"][:-2]:
            self.assertEqual(axis["unavailable_cycles"], 0, axis)

    def test_every_fault_has_a_record_of_its_own(self):
        (self.directory / "out").mkdir()
        self.write("out/flight_recorder.3.csv", "of an earlier run")
        result, document = self.run_line(fault("power-off", 2000, slave='"v"', for_ms=300),
                                         fault("power-off", 5000, slave='"v"', for_ms=300),
                                         head='[recovery]\naxes = "continue"')
        self.assertEqual(result.returncode, 0, result.stderr)
        records = {key: name for key, name in document["files"].items() if key.startswith("flight")}
        self.assertEqual(records, {"flight_recorder_csv": "out/flight_recorder.csv",
                                   "flight_recorder_2_csv": "out/flight_recorder.2.csv"})
        for name in records.values():
            self.assertIn(f"cycles around the fault are in {name}", result.stderr)
            with open(self.directory / name, encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual(len(rows), 2048)
            self.assertEqual([row["v.available"] for row in (rows[0], rows[-1])], ["1", "0"])
        self.assertNotIn("out/flight_recorder.3.csv", self.files())

    def test_a_ring_that_breaks_costs_nothing(self):
        for at, (first, second) in enumerate(zip(AXES, AXES[1:])):
            with self.subTest(cable=f"{first} to {second}"):
                result, document = self.run_line(
                    fault("cable-break", 2000, slave=f'"{first}"', to=f'"{second}"', for_ms=1000),
                    head='[wiring]\npreset = "ring"', duration=4)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(document["faults"], [f"the ring is broken between slave {at} and slave {at + 1}; "
                                                      "process data continue over both interfaces"])
                self.assertIn("the ring is closed again", "\n".join(document["events"]))
                self.assertEqual((document["lost_frames"], document["wkc_errors"]), (0, 0))
                self.assertEqual({axis["unavailable_cycles"] for axis in document["axes"]}, {0})

    def test_a_drive_of_a_ring_that_is_switched_off_takes_nobody_along(self):
        result, document = self.run_line(fault("power-off", 3000, slave='"z"', for_ms=700),
                                         head='[recovery]\naxes = "continue"\n[wiring]\npreset = "ring"')
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(document["recoveries"], 1)
        self.check_back(document, 2)
        self.assertEqual({axis["unavailable_cycles"] for axis in document["axes"] if axis["name"] != "z"}, {0})


class OnTheWire(WireTest):
    def start_both(self, policy):
        # An axis is missing after 40 cycles, and a drive without outputs falls to SAFEOP after 100 ms.
        config = self.write_gentle_line(bears_stalls=False, cycle_us=2000, realtime="cpu = 1\nsimulation_cpu = 0",
                                        head=f'[recovery]\naxes = "{policy}"')
        line = self.start("simulate", "--config", config, "--iface", "dl-line", "--control", "line.socket",
                          log="line.log")
        self.wait_for("the simulated line", lambda: "slaves on dl-line" in self.text("line.log"), line)
        return line, self.start_master(config, "--control", "run.socket")

    def fault(self, *words):
        result = self.run_program("fault", "--control", "line.socket", *words)
        self.assertEqual(result.returncode, 0, result.stderr)

    def diag(self):
        result = self.run_program("diag", "--control", "run.socket", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.one_document(result.stdout)

    @staticmethod
    def exchanged(group):
        return group["bad_cycles"] == 0 and group["working_counter"] == group["expected_working_counter"]

    def diag_when(self, what, master, holds):
        """The first diagnosis for which `holds` is true: a frame of the cycle before may just have been late."""
        found = []
        self.wait_for(what, lambda: found.append(self.diag()) or holds(found[-1]), master)
        return found[-1]

    def wait_for_sentence(self, sentence, master, times=1):
        self.wait_for(sentence, lambda: self.text("master.log").count(sentence) >= times, master)

    @again_when(*DISTURBED)
    def test_faults_come_and_go_while_the_line_runs(self):
        _, master = self.start_both("continue")
        self.assertEqual({slave["state"] for slave in self.diag()["slaves"]}, {"OP"})
        for number, (begin, heal) in enumerate(((["power-off", "slave=v"], ["power-off", "slave=v"]),
                                                (["cable-break", "slave=u", "to=v"], ["cable-break", "slave=u", "to=v"]),
                                                (["short-wkc", "slave=v"], ["short-wkc", "slave=v"])), start=1):
            self.fault(*begin)
            self.wait_for_sentence("axis v: unavailable", master, number)
            if begin[0] == "short-wkc":  # its watchdog takes its time
                self.wait_for_sentence(f"slave {LAST} (v): left OP", master)
            self.fault("heal", *heal)
            self.wait_for_sentence(f"slave {LAST} (v): back in OP", master, number)
            self.wait_for_sentence("axis v: back on the path", master, number)
        found = self.diag_when("all slaves exchange process data", master, lambda found: self.exchanged(found["groups"][0]))
        self.assertEqual([slave["state"] for slave in found["slaves"]], ["OP"] * len(AXES))
        self.assertGreater(found["cycle"]["cycles"], 100)
        self.assertGreater(found["cycle"]["cycle_cost_ns"]["p50"], 0)
        told = [event["sentence"] for event in found["events"]]
        self.assertEqual(told.count(f"slave {LAST}: back in OP"), 3)
        self.assertTrue(any(place["kind"] == "lost_link" and place["slave"] == LAST - 1 for place in found["places"]),
                        found["places"])
        text = self.run_program("diag", "--control", "run.socket").stdout
        for part in ("wrong\n", "slaves\n", "exchange: ", "group 0: working counter", "cycle: ", "wake-up latency",
                     "what happened\n", "back in OP"):
            self.assertIn(part, text)
        self.assertEqual(self.end(master, signal.SIGTERM), 0, self.logs())
        document = self.one_document(self.text("master.log.out"))
        self.assertEqual(document["state"], "OP")
        self.assertGreaterEqual(document["recoveries"], 3)
        self.assertNotIn("run.socket", self.files())

    @again_when(*DISTURBED)
    def test_a_drive_is_waited_for(self):
        _, master = self.start_both("hold")
        self.fault("power-off", "slave=z")
        self.wait_for_sentence("waiting for an axis", master)
        self.assertFalse(self.diag()["slaves"][2]["answers"])
        self.fault("heal", "power-off", "slave=z")
        for name in "zabcuv":
            self.wait_for_sentence(f"axis {name}: back on the path", master)
        self.assertEqual(self.end(master, signal.SIGTERM), 0, self.logs())

    def test_questions_that_cannot_be_answered(self):
        self.check_refused(self.run_program("diag", "--control", "nobody.socket"), 1, "nobody.socket", "run --control")
        self.check_refused(self.run_program("diag", "--control", "x", "--iface", "dl-master"), 2, "--control")
        self.check_refused(self.run_program("diag", "--control", "x", "--clear"), 2, "--clear")


class Ring(RingTest):
    def fault(self, *words):
        result = self.run_program("fault", "--control", "line.socket", *words)
        self.assertEqual(result.returncode, 0, result.stderr)

    def diag(self):
        result = self.run_program("diag", "--control", "run.socket", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.one_document(result.stdout)

    @again_when_disturbed
    def test_every_cable_breaks_and_is_mended_while_the_line_runs(self):
        config = self.write_gentle_line(cycle_us=2000, realtime="cpu = 1\nsimulation_cpu = 0",
                                        head='[wiring]\npreset = "ring"')
        line = self.start("simulate", "--config", config, "--iface", "dl-line", "--iface2", "dl-line2", "--control",
                          "line.socket", log="line.log")
        self.wait_for("the ring", lambda: "slaves on dl-line and dl-line2" in self.text("line.log"), line)
        master = self.start_master(config, "--iface2", "dl-master2", "--control", "run.socket")
        for at, (first, second) in enumerate(zip(AXES, AXES[1:])):
            self.fault("cable-break", f"slave={first}", f"to={second}")
            sentence = f"the ring is broken between slave {at} and slave {at + 1};"
            self.wait_for(sentence, lambda sentence=sentence: sentence in self.text("master.log"), master)
            there = {"state": "open", "primary_slaves": at + 1, "secondary_slaves": len(AXES) - at - 1}
            self.wait_for(f"{sentence} in the diagnosis", lambda there=there: self.diag()["ring"] == there, master)
            self.assertEqual({slave["state"] for slave in self.diag()["slaves"]}, {"OP"})
            self.fault("heal", "all")
            self.wait_for("the ring is whole", lambda at=at: self.text("master.log").count(
                "the ring is closed again") > at, master)
        self.assertEqual(self.end(master, signal.SIGTERM), 0, self.logs())
        document = self.one_document(self.text("master.log.out"))
        ring = document["ring"]
        self.assertEqual(ring["state"], "closed")
        self.assertGreater(ring["merged"], 0)
        # A break, and a mending, costs what is under way in that moment: one frame of process data and one of other work.
        # Frames that a busy machine has delayed are lost as well, and counted separately.
        under_way = 2 * (len(AXES) - 1)
        self.assertLessEqual(ring["halves"] - ring["late_halves"], 2 * under_way)
        self.assertLessEqual(document["wkc_errors"] - ring["late_halves"], under_way)
        self.assertEqual({axis["unavailable_cycles"] for axis in document["axes"]}, {0})
        self.assertEqual(document["state"], "OP")

    def test_one_interface_is_no_ring(self):
        config = self.write_gentle_line(cycle_us=2000)
        for arguments, part in ((["--iface2", "dl-master"], "--iface"),
                                (["--iface", "dl-master", "--iface2", "dl-master"], "two ends")):
            self.check_refused(self.run_program("run", "--config", config, *arguments), 2, "--iface2", part)


if __name__ == "__main__":
    unittest.main()
