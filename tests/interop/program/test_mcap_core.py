"""Recordings as the libraries read them that Foxglove is built of: @mcap/core, and its decoder of messages of ROS 2."""
import json
import sys
import unittest

import npm_modules
from program import EXAMPLES, ROOT, again_when_disturbed
from test_clients import BATCH, STATUS, TELEMETRY, ClientTest, recorded_name

sys.path.insert(0, str(EXAMPLES))
import read_recording  # noqa: E402

SOURCES = ROOT / "tests/interop/mcap"


class McapCore(ClientTest):
    @classmethod
    def setUpClass(cls):
        cls.modules = npm_modules.install("mcap", "@mcap/core")

    def read(self, name):
        result = self.run_program(SOURCES / "read_recording.mjs", name, self.modules, program="node")
        self.assertEqual(result.returncode, 0, result.stderr)
        head, *samples = map(json.loads, result.stdout.splitlines())
        return head, samples

    @again_when_disturbed
    def test_reads_every_sample(self):
        run = self.start_run(telemetry="ros2 = true")
        told = self.record("run.mcap", "--duration", 3)
        self.end_run(run)
        head, read = self.read("run.mcap")
        self.assertTrue(head["complete"])
        self.assertEqual(head["counts"], {recorded_name(name): topic["samples"] for name, topic in told.items()})
        self.assertEqual(head["records"]["ChunkIndex"], head["chunks"])
        self.assertEqual(head["profile"], "ros2")
        self.assertEqual(head["types"]["/joint_states"], "sensor_msgs/msg/JointState")
        self.assertIn("reliability: 1\n", head["qos"]["/joint_states"])
        self.assertEqual((head["records"]["Metadata"], head["records"]["MetadataIndex"]), (1, 1))
        for name in told:
            self.assertEqual(sorted(sample["sequence"] for sample in read if sample["topic"] == recorded_name(name)),
                             list(range(told[name]["samples"])))
        self.check_values(read)

    def check_values(self, read):
        """What another decoder finds in the same bytes; there numbers of 64 bits are texts, and enumerations numbers."""
        for topic, field in ((BATCH, "number"), (TELEMETRY, "cycle"), (STATUS, "cycle")):
            ours = [sample for _, _, sample in read_recording.samples(self.directory / "run.mcap", topic)]
            theirs = [sample["sample"] for sample in read if sample["topic"] == topic]
            self.assertEqual([sample[field] for sample in ours], [int(sample[field]) for sample in theirs])
        batch = next(sample for _, _, sample in read_recording.samples(self.directory / "run.mcap", BATCH))
        theirs = next(sample["sample"] for sample in read if sample["topic"] == BATCH)
        self.assertEqual([sample["actual_position"] for sample in batch["samples"]], [sample["actual_position"] for sample in theirs["samples"]])
        self.assertEqual({sample["state"] for sample in theirs["samples"]}, {4}, "AXIS_OPERATION_ENABLED")


if __name__ == "__main__":
    unittest.main()
