"""The line of the example examples/by_hand.toml with limits that a machine that stands still for seconds keeps."""
import re

LONGEST_WATCHDOG_MS = 6500  # of what a line description takes (docs/command_line.md)
MOST_LOST_CYCLES = 10_000  # the same


def patient_line(examples):
    """The text of the line description; `examples`: the folder with the installed examples."""
    text = (examples / "by_hand.toml").read_text(encoding="utf-8")
    text = re.sub(r"(?m)^max_lost_ms = .*$", f"max_lost_cycles = {MOST_LOST_CYCLES}", text)
    return re.sub(r'(?m)^(\[\[slave\]\]\nname = ".*"\n)', rf"\1watchdog = {{process_data_ms = {LONGEST_WATCHDOG_MS}}}\n", text)
