"""A CANopen master that is killed, and a drive that is switched off and on: what the drives of a served line do by themselves, and
that the run brings them back."""
import json
import signal
import unittest

from can_lines import CanMasterTest
from program import PATIENCE_S, again_when_disturbed

FAULT = 0x08  # of 6041h
NODES = {"heartbeat": 1, "guarding": 2, "telegram": 3}
# P 2061 = 1: RPDOs; P 2062: the time-out in ms (MSD manual Table 8.6).
TELEGRAM = ('[[slave.sdo]]\nindex = 0x280D\ntype = "uint8"\nvalue = 1\n'
            '[[slave.sdo]]\nindex = 0x280E\ntype = "uint32"\nvalue = 400\n')
SLAVES = {"heartbeat": "heartbeat_ms = 100\n", "guarding": "guard_ms = 100\n", "telegram": "heartbeat_ms = 0\n" + TELEGRAM}


class KilledMaster(CanMasterTest):
    def line(self, slaves, head=""):
        names = list(slaves)
        swing = "\n".join(f"{time},{','.join([str(turns)] * len(names))}" for time, turns in ((0, 0), (1, 0.25), (2, 0)))
        self.write("swing.csv", f"time[s],{','.join(f'{name}[rev]' for name in names)}\n{swing}\n")
        text = "".join(f'[[slave]]\nname = "{name}"\nnode = {NODES[name]}\n{keys}' for name, keys in slaves.items())
        axes = "".join(f'[[axis]]\nname = "{name}"\ninertia = 3.0e-4\n' for name in names)
        return self.write("line.toml", f"""
[bus]
type = "can"
sync_ms = 10
max_lost_cycles = 40
[realtime]
policy = "degrade"
[telemetry]
enabled = false
[path]
file = "swing.csv"
relative = true
repeat = true
{head}
{text}{axes}""")

    def follow(self, config, *arguments):
        port = self.serve(self.write("served.toml", '[bus]\ntype = "can"\n' + "".join(
            f'[[slave]]\nname = "{name}"\nnode = {node}\n' for name, node in NODES.items())), "--control", "can.socket")
        master = self.start("run", "--config", config, "--iface", f"slcan:tcp:127.0.0.1:{port}", "--no-plots", *arguments,
                            log="master.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("master.log"), master)
        return port, master

    def test_every_drive_stops_by_itself(self):
        port, master = self.follow(self.line(SLAVES))
        for node in NODES.values():
            self.assertEqual(self.upload(port, node, 0x6041) & 0x6F, 0x27, "the motor is under control")
        self.kill_hard(master)
        for name, node in NODES.items():
            self.wait_for(f"the fault of {name}", lambda node=node: (self.upload(port, node, 0x6041) or 0) & FAULT, self.server)
            self.assertNotEqual(self.upload(port, node, 0x603F), 0, name)
        places = [self.upload(port, node, 0x6064) for node in NODES.values()]
        self.assertEqual([self.upload(port, node, 0x6064) for node in NODES.values()], places, "they stand")

    @again_when_disturbed
    def test_a_drive_that_is_switched_off_and_on_is_back_without_a_restart(self):
        slaves = {"heartbeat": "heartbeat_ms = 100\n", "guarding": "heartbeat_ms = 100\n"}
        _, master = self.follow(self.line(slaves, head='[recovery]\naxes = "hold"'), "--json")
        order = self.run_program("fault", "--control", "can.socket", "power-off", "slave=1", "for_ms=500")
        self.assertEqual(order.returncode, 0, order.stderr)
        self.wait_for("the drive is back", lambda: "axis guarding: back on the path" in self.text("master.log"), master)
        master.send_signal(signal.SIGINT)
        self.assertEqual(master.wait(PATIENCE_S), 0, self.text("master.log"))
        document = json.loads(self.text("master.log.out"))
        self.assertEqual(document["recoveries"], 1)
        self.assertEqual(document["axes"][0]["unavailable_cycles"], 0)
        self.assertGreater(document["axes"][1]["unavailable_cycles"], 0)


if __name__ == "__main__":
    unittest.main()
