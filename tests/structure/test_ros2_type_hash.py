"""The type hash that the bridge tells is that of the message of ROS 2, and our script computes it."""
import re
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import ros2_type_hash as r  # noqa: E402  pylint: disable=wrong-import-position

# Of sensor_msgs/msg/JointState, as ROS 2 publishes it.
JOINT_STATE = "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"


class TypeHash(unittest.TestCase):
    def test_of_joint_states_is_that_of_ros_2(self):
        self.assertEqual(r.type_hash("sensor_msgs/msg/JointState"), JOINT_STATE)

    def test_is_the_one_that_the_bridge_tells(self):
        source = (ROOT / "bridge/src/joint_states.hpp").read_text(encoding="utf-8")
        self.assertEqual(re.findall(r'"typehash=(\w+);"', source), [JOINT_STATE])

    def test_of_diagnostics_is_the_one_that_the_bridge_tells(self):
        source = (ROOT / "bridge/src/diagnostics.hpp").read_text(encoding="utf-8")
        self.assertEqual(re.findall(r'"typehash=(\w+);"', source), [r.type_hash("diagnostic_msgs/msg/DiagnosticArray")])

    def test_changes_with_a_field(self):
        before = r.TYPES["std_msgs/msg/Header"]
        self.addCleanup(r.TYPES.update, {"std_msgs/msg/Header": before})
        r.TYPES["std_msgs/msg/Header"] = list(reversed(before))
        self.assertNotEqual(r.type_hash("sensor_msgs/msg/JointState"), JOINT_STATE)


if __name__ == "__main__":
    unittest.main()
