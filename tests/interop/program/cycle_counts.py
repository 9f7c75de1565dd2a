"""What happens to the thread of the cycle while others are attacked, by counts that do not depend on how fast the machine is: how often it
gave the processor away, its page faults, what it read and wrote, and what memory its process has."""
import os
import pathlib
import time


class CycleCounts:
    """For tests of a run with a cycle of 1 ms."""

    WINDOW_S = 2
    PERIOD_US = 1000

    def counts(self, run):
        tasks = pathlib.Path(f"/proc/{run.pid}/task")
        [cycle] = [task for task in tasks.iterdir() if (task / "comm").read_text().strip() == "driveline-rt"]
        status = dict(line.split(":\t", 1) for line in (cycle / "status").read_text().splitlines() if ":\t" in line)
        stat = (cycle / "stat").read_text().rpartition(")")[2].split()
        io = dict(line.split(": ") for line in (cycle / "io").read_text().splitlines())
        return {"gave way": int(status["voluntary_ctxt_switches"]), "page faults": int(stat[7]) + int(stat[9]),
                "reads and writes": int(io["syscr"]) + int(io["syscw"]), "data KiB": int(status["VmData"].split()[0]),
                "instants": time.monotonic() * 1e6 / self.PERIOD_US}

    def since(self, run, before):
        after = self.counts(run)
        locked = int(pathlib.Path(f"/proc/{run.pid}/status").read_text().partition("VmLck:")[2].split()[0])
        return {"locked": locked, **{name: after[name] - before[name] for name in before}}

    def window(self, run, begin=lambda: None, end=lambda: None):
        """What is counted while something happens for two seconds."""
        before = self.counts(run)
        begin()
        time.sleep(self.WINDOW_S)
        counted = self.since(run, before)
        end()
        return counted

    def check_counts(self, what, counted, quiet):
        if os.environ.get("DRIVELINE_SANITIZE"):
            return  # a sanitizer waits and allocates in every thread
        # Once for each instant of the grid; who waits for somebody else does it more often.
        self.assertLessEqual(counted["gave way"], 1.01 * counted["instants"] + 20, (what, counted, quiet))
        self.assertGreater(counted["gave way"], 0, f"{what}: it stands still")
        if counted["locked"]:  # who may not lock memory has page faults of his own
            self.assertEqual(counted["page faults"], 0, (what, counted, quiet))
        self.assertEqual(counted["reads and writes"], 0, (what, counted, quiet))
        self.assertLessEqual(counted["data KiB"], quiet["data KiB"] + 1024, (what, counted, quiet))
