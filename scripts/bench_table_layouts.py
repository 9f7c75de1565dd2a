"""Layouts of the tables in docs/ that are made from the documents of bench/: one function per table.

Each takes the documents by the name of their program and returns the lines between the markers of the table.
"""
import json
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TO_NS = {"ns": 1.0, "us": 1e3, "ms": 1e6}
# Below this the processors of the machine were as good as free.
QUIET = 0.1

CLOCK_LINES = {
    "line_2": "2 slaves", "line_16": "16 slaves", "line_64": "64 slaves", "line_128": "128 slaves",
    "line_64_temperature_1ppm_s": "64, speeds wander by 1 ppm/s",
    "line_64_receive_jitter_20ns": "64, receive times ±20 ns",
    "line_64_wake_jitter": "64, master wakes late as measured (p50 {p50}, p99 {p99})",
    "line_64_loss_1pct": "64, 1 % of the frames lost",
    "line_64_everything": "64, all of that together",
    "branch_64": "64 in branches",
    "ring_64": "64 in a ring",
    "ring_64_broken": "the same, broken in the middle: all 64",
    "ring_64_temperature_1ppm_s": "64 in a ring, speeds wander by 1 ppm/s",
    "ring_64_temperature_1ppm_s_broken": "the same, broken in the middle: all 64",
}


class Figures:
    """A document, its rows by case and metric."""

    def __init__(self, document):
        self.document = document
        self.rows = {(row["case"], row["metric"]): row for row in document["results"]}

    def cases(self, metric):
        return [row["case"] for row in self.document["results"] if row["metric"] == metric]

    def row(self, case, metric):
        return self.rows[(case, metric)]

    def time(self, case, metric, key="p50"):
        row = self.row(case, metric)
        return duration(row[key] * TO_NS[row["unit"]])


def duration(ns):
    """Three digits, in the unit that suits it."""
    for unit, size in (("s", 1e9), ("ms", 1e6), ("µs", 1e3), ("ns", 1.0)):
        if ns >= size or unit == "ns":
            value = ns / size
            return f"{value:.0f} {unit}" if value >= 99.95 else f"{value:.3g} {unit}"
    return ""


def limits(row):
    """The aims of a row by percentile: {"p50": 150.0}."""
    return {key: float(value) for key, value in re.findall(r"(p\d+)<=([\d.e+]+)", row.get("aim", ""))}


def verdict(row, key="p50"):
    """met or missed, by the figure itself; empty without an aim."""
    limit = limits(row).get(key)
    return "" if limit is None else "met" if row[key] <= limit else "**missed**"


def aim_of(row):
    """In words, for the title of a column; of the median."""
    return f"aim {limits(row)['p50']:g}"


def aimed_ratio(row, floor, key):
    """An aim that is a multiple of a floor, by the name of that floor."""
    return f"aim {limits(row)[key] / floor[key]:.3g}"


def table(header, rows):
    """`header`: title and alignment of each column."""
    lines = ["| " + " | ".join(title for title, _ in header) + " |",
             "|" + "|".join({"l": "---", "r": "---:"}[side] for _, side in header) + "|"]
    return lines + ["| " + " | ".join(row) + " |" for row in rows]


def build_of(where):
    changes = " with changes that are not in it" if where.get("uncommitted") else ""
    return f"{where['compiler']}, {where.get('build', '?')}, commit {where['commit'] or 'unknown'}{changes}"


def where_from(document):
    """Where and when figures come from that depend on the machine."""
    where = document["environment"]
    machine = f"{where['cpu']}, {where['cores']} processors" + (", virtual machine" if where["virtual_machine"] else "")
    text = f"Measured {where['date']} on {machine}, Linux {where['kernel']}; {build_of(where)}. "
    other, stolen = where["other_load"], where["stolen_load"]
    text += f"Meanwhile other programs took {other:.2f} processors and the hypervisor took {stolen:.2f}"
    text += ": **the machine was busy**." if other + stolen > QUIET else "."
    if where.get("short"):
        text += " **Short form, as in a report of all programs.**"
    if where.get("quick"):
        text += " **Quick form: a tenth of the measurements.**"
    return [text, ""]


def cycle(documents):
    figures = Figures(documents["cycle"])
    rows = []
    for case in figures.cases("whole_cycle"):
        pace, axes = re.fullmatch(r"(back_to_back|paced)_(\d+)_axes", case).groups()
        whole, each = figures.row(case, "whole_cycle"), figures.row(case, "master_part_per_axis")
        aims = [f"{duration(limits(row)['p50'] * TO_NS[row['unit']])}: {verdict(row)}" for row in (whole, each)
                if limits(row)]
        rows.append([axes, pace.replace("_", " "), figures.time(case, "whole_cycle"),
                     figures.time(case, "whole_cycle", "p999"), figures.time(case, "master_part"),
                     figures.time(case, "master_part_per_axis"), figures.time(case, "master_part_per_axis", "p999"),
                     "; ".join(aims)])
    return where_from(documents["cycle"]) + table(
        [("axes", "r"), ("", "l"), ("whole cycle p50", "r"), ("p99.9", "r"), ("the master's part p50", "r"),
         ("per axis p50", "r"), ("p99.9", "r"), ("aims for the whole cycle; the master per axis", "l")], rows)


def esc(documents):
    figures = Figures(documents["esc"])
    rows = []
    for case in figures.cases("cost_per_slave"):
        slaves = re.fullmatch(r"brd_(\d+)_slaves", case)
        if not slaves:
            continue
        cells = [slaves[1]]
        for what in ("brd", "fprd_elsewhere", "lrw_23_23", "lrw_23_23_and_hand_over"):
            row = figures.row(f"{what}_{slaves[1]}_slaves", "cost_per_slave")
            cells.append(f"{row['p50']:.1f}" + (f": {verdict(row)}" if limits(row) else ""))
        cells.append(f"{figures.row(f'lrw_23_23_{slaves[1]}_slaves', 'cost_per_slave')['p999']:.1f}")
        memory = figures.row(f"{slaves[1]}_slaves", "resident_memory")
        cells.append(f"{memory['p50']:.1f}" + (f": {verdict(memory)}" if limits(memory) else ""))
        rows.append(cells)
    return where_from(documents["esc"]) + table(
        [("slaves", "r"), ("BRD, ns", "r"),
         (f"FPRD elsewhere, ns ({aim_of(figures.row('fprd_elsewhere_1_slaves', 'cost_per_slave'))})", "r"),
         (f"LRW, ns ({aim_of(figures.row('lrw_23_23_1_slaves', 'cost_per_slave'))})", "r"),
         ("LRW and hand-over, ns", "r"), ("LRW p99.9, ns", "r"),
         (f"memory of the process, MiB ({aim_of(figures.row('256_slaves', 'resident_memory'))})", "r")], rows)


def eoe_case(case):
    """"veth_125us_8_drives": over veth, 125 µs, 8."""
    where, cycle, drives = re.fullmatch(r"(in_process|veth)_(\d+)us_(\d+)_drives?", case).groups()
    return {"in_process": "in process", "veth": "over veth"}[where], duration(1e3 * int(cycle)), drives


def eoe(documents):
    figures = Figures(documents["eoe"])
    rows = []
    for case in figures.cases("tcp_echo_per_mib"):
        row = figures.row(case, "tcp_echo_per_mib")
        where, cycle, drives = eoe_case(case)
        speed = lambda ms: f"{1e3 / ms:.2f}"
        limit = row["p50"] / row["ratio_p50"]
        aim = f"{limit / limits(row)['p50']:.2g}" if drives == "1" else f"{speed(limits(row)['p50'])} MiB/s, that of one"
        rows.append([drives, where, cycle, speed(row["p50"]), speed(limit), f"{1 / row['ratio_p50']:.2f}", f"{aim}: {verdict(row)}",
                     figures.time(case, "ping"), figures.time(case, "ping", "p99")])
    return where_from(documents["eoe"]) + table(
        [("drives", "r"), ("", "l"), ("cycle", "r"), ("MiB/s each way, median", "r"), ("arithmetic limit", "r"), ("part of it", "r"),
         ("aim", "l"), ("ping p50", "r"), ("p99", "r")], rows)


def eoe_cost(documents):
    figures = Figures(documents["eoe"])
    rows = []
    for case in figures.cases("cycle_cost_p999_with_over_without"):
        upper = figures.row(case, "cycle_cost_p999_upper_end_of_95_interval")
        rows.append([eoe_case(case)[0], f"{figures.row(case, 'cycle_cost_p999_with_over_without')['p50'] / 100:.2f}",
                     f"{upper['p50'] / 100:.2f}", f"{limits(upper)['p50'] / 100:.2f}: {verdict(upper)}",
                     f"{figures.row(case, 'wake_latency_p999_with_over_without')['p50'] / 100:.2f}",
                     f"{figures.row(case, 'wake_latency_p999_upper_end_of_95_interval')['p50'] / 100:.2f}"])
    return table([("one drive, 125 µs", "l"), ("p99.9 of the cycle's cost with load over without, median", "r"),
                  ("upper end of the 95 % interval", "r"), ("aim", "l"), ("the same of the wake-up latency", "r"), ("upper end", "r")],
                 rows)


def drive(documents):
    figures = Figures(documents["drive"])
    names = {("1_drive", "cost_per_cycle"): "one drive, per cycle of 125 µs",
             ("100_drives", "cost_per_cycle"): "100 drives, per cycle",
             ("100_drives", "cost_per_drive"): "100 drives, each",
             ("drive", "state"): "memory of a drive",
             ("drive_and_slave_controller", "state"): "memory of a drive and its slave controller"}
    rows = []
    for (case, metric), name in names.items():
        row = figures.row(case, metric)
        in_time = row["unit"] in TO_NS
        show = (lambda value, unit=row["unit"]: duration(value * TO_NS[unit])) if in_time else \
               (lambda value, unit=row["unit"]: f"{value:.1f} {unit}")
        aim = f"{show(limits(row)['p50'])}: {verdict(row)}" if limits(row) else ""
        ratio = row.get("ratio_turns", {}).get("mean", row.get("ratio_p50"))  # by turns: that of the same moments
        against = f"{ratio:.2f}" if "against" in row else ""
        rows.append([name, show(row["p50"]), show(row["p999"]) if in_time else "", against, aim])
    return where_from(documents["drive"]) + table(
        [("", "l"), ("p50", "r"), ("p99.9", "r"), ("times controllers and motor alone", "r"), ("aim", "l")], rows)


def can(documents):
    if "can" not in documents:
        return ["Not measured yet: `scripts/bench_tables.py --run can` on an idle machine fills this table."]
    figures = Figures(documents["can"])
    rows = []

    def add(name, case, metric, show, floor="", aim=""):
        row = figures.row(case, metric)
        ratio = row.get("ratio_turns", {}).get("mean", row.get("ratio_p50"))
        against = f"{ratio:.2f} {floor}" if "against" in row else ""
        rows.append([name, show(row), against, f"{aim}: {verdict(row)}" if limits(row) else ""])

    in_time = lambda row: duration(row["p50"] * TO_NS[row["unit"]])
    plain = lambda row: f"{row['p50']:.1f} {row['unit']}"
    number = lambda row: f"{row['p50']:,.0f}"
    add("load of the bus against the arithmetic", "bus_load", "bits_off_the_arithmetic", lambda row: f"{row['p50']:.0f} bits off", aim="0")
    add("a frame through the bus to 8 nodes", "frame_to_8_nodes", "cost", in_time, "times CRC, stuff bits and 8 copies", "2.0")
    add("drive with plant, 2 ms", "drive_and_plant", "cost_in_2_ms", in_time)
    add("its front end per SYNC of 2 ms", "front_end", "cost_per_sync", in_time, "of that", "0.10")
    add("the same, with the frames of 7 others", "front_end_of_8_on_a_bus", "cost_per_sync", in_time, "of that")
    add("segmented upload of 100 bytes", "upload_of_100_bytes", "time", in_time)
    add("off time on the bus and 16 delays of the server", "upload_of_100_bytes", "off_the_arithmetic", plain, aim="1 %")
    add("memory of a front end without its drive", "node_without_drive", "state", plain, aim="8 KiB")
    add("memory of an MSD with its front end", "msd", "state", plain, aim="30 KiB")
    add("master of 8 axes, its part of a cycle", "master_of_8_axes", "master_part", in_time, "times that on EtherCAT", "1.25")
    add("line of 8 axes on virtual time, a cycle", "line_of_8_axes_virtual", "processor_time_per_cycle", in_time, "times that on EtherCAT", "1.0")
    add("SYNC behind the grid, p99", "sync_of_8_axes", "p99_of_a_turn", in_time, "times a loop that sleeps and sends", "1.1")
    add("slcan on TCP, full bus: frames lost", "slcan_full_bus", "frames_lost", number, aim="0")
    add("frames per second", "slcan_full_bus", "frames_per_second", number)
    add("load", "slcan_full_bus", "load", plain)
    add("slcan on TCP, round trip of a command", "slcan_command", "round_trip", in_time, "times a TCP echo", "1.5")
    return where_from(documents["can"]) + table([("", "l"), ("p50", "r"), ("against", "l"), ("aim", "l")], rows)


def master_cost(documents):
    figures = Figures(documents["master_cost"])
    rows = []
    for case in figures.cases("send_receive_decode"):
        row = figures.row(case, "send_receive_decode")
        bare = figures.row(case, "against_af_packet")
        ring = figures.row(case, "bare_packet_mmap_loop")
        rows.append([case.split("_")[0], figures.time(case, "bare_packet_mmap_loop"),
                     figures.time(case, "send_receive_decode"), f"{row['ratio_p50']:.2f}: {verdict(row)}",
                     figures.time(case, "bare_packet_mmap_loop", "p999"),
                     figures.time(case, "send_receive_decode", "p999"),
                     f"{row['ratio_p999']:.2f}: {verdict(row, 'p999')}", figures.time(case, "bare_af_packet_loop"),
                     f"{bare['ratio_p50']:.2f}"])
    return where_from(documents["master_cost"]) + table(
        [("axes", "r"), ("ring loop p50", "r"), ("master p50", "r"), (f"ratio, {aimed_ratio(row, ring, 'p50')}", "l"),
         ("ring loop p99.9", "r"), ("master p99.9", "r"), (f"ratio, {aimed_ratio(row, ring, 'p999')}", "l"),
         ("`send` and `recv` loop p50", "r"), ("ratio", "r")], rows)


def startup(documents):
    figures = Figures(documents["startup"])
    rows = []
    for case in figures.cases("first_frame_to_op"):
        where, drives = re.fullmatch(r"(in_process|veth)_(\d+)_drives", case).groups()
        row = figures.row(case, "first_frame_to_op")
        aim = f"{duration(limits(row)['p50'] * TO_NS[row['unit']])}: {verdict(row)}" if limits(row) else ""
        rows.append([drives, {"in_process": "in process", "veth": "over veth"}[where],
                     figures.time(case, "first_frame_to_op"), figures.time(case, "first_frame_to_op", "max"),
                     figures.time(case, "discovery"), figures.time(case, "configuration_to_safe_op"),
                     figures.time(case, "to_op"), aim])
    return where_from(documents["startup"]) + table(
        [("drives", "r"), ("", "l"), ("first frame to OP, median", "r"), ("largest", "r"), ("of which discovery", "r"),
         ("configuration", "r"), ("to OP", "r"), ("aim", "l")], rows)


def startup_memory(documents):
    figures = Figures(documents["startup"])
    names = {"memory_of_the_master": "the master",
             "memory_of_the_process": "the whole process, master and 256 simulated drives"}
    rows = []
    for metric, name in names.items():
        row = figures.row("in_process_256_drives", metric)
        rows.append([name, f"{row['p50']:.1f} MiB", f"{limits(row)['p50']:g} MiB: {verdict(row)}"])
    return table([("memory, 256 configured drives", "l"), ("", "r"), ("aim", "l")], rows)


def turnaround(documents):
    figures = Figures(documents["turnaround"])
    rows = []
    for case in figures.cases("round_trip"):
        drives, busy, kind = re.fullmatch(r"(\d+)_drives(_busy_poll)?_(recv|packet_mmap)", case).groups()
        row = figures.row(case, "round_trip")
        if limits(row):
            aim = aimed_ratio(row, figures.row(case, "echo_round_trip"), "p50")
        rows.append([drives, "spinning" if busy else "sleeping", {"recv": "`recv`", "packet_mmap": "ring"}[kind],
                     figures.time(case, "echo_round_trip"), figures.time(case, "round_trip"),
                     figures.time(case, "echo_round_trip", "p99"), figures.time(case, "round_trip", "p99"),
                     f"{row['ratio_p50']:.2f}" + (f": {verdict(row)}" if limits(row) else "")])
    return where_from(documents["turnaround"]) + table(
        [("drives", "r"), ("", "l"), ("socket of both", "l"), ("echo p50", "r"), ("line p50", "r"), ("echo p99", "r"),
         ("line p99", "r"), (f"ratio of the medians, {aim} with a ring", "l")], rows)


def wake(documents):
    figures = Figures(documents["wake"])
    names = {"clock_nanosleep_loop": "`clock_nanosleep` loop (the floor)", "cycle_timer": "`CycleTimer`",
             "cycle_timer_25us_ahead": "`CycleTimer`, 25 µs ahead"}
    rows = [[name, *(figures.time(case, "wake_latency", key) for key in ("p50", "p99", "p999", "max"))]
            for case, name in names.items()]
    return where_from(documents["wake"]) + table(
        [("", "l"), ("p50", "r"), ("p99", "r"), ("p99.9", "r"), ("max", "r")], rows)


def wake_percentiles():
    """Of the wake-up latency that bench/dc plays back: the upper ends of the bins."""
    bins = json.loads((ROOT / "bench/data/wake_latency.json").read_text(encoding="utf-8"))["bins"]
    total = sum(one["count"] for one in bins)
    found = {}
    for key, share in (("p50", 0.5), ("p99", 0.99)):
        seen = 0
        for one in bins:
            seen += one["count"]
            if seen >= share * total:
                found[key] = f"below {duration(one['below_ns'])}"
                break
    return found


def dc(documents):
    figures = Figures(documents["dc"])
    rows = []
    for case in figures.cases("sync0_peak"):
        lock = figures.rows.get((case, "time_to_lock"))
        cells = [CLOCK_LINES[case].format(**wake_percentiles()) if "wake_jitter" in case else CLOCK_LINES[case],
                 f"{lock['p50']:.0f} ms" if lock else ""]
        peak, rms = figures.row(case, "sync0_peak"), figures.row(case, "sync0_rms")
        cells += [f"{peak['p50']:.0f} ns", f"{rms['p50']:.1f} ns",
                  f"{figures.row(case, 'grid_phase_error')['max']:.0f} ns"]
        aimed = [row for (of, _), row in figures.rows.items() if of == case and limits(row)]
        cells.append("**missed**" if any(verdict(row) != "met" for row in aimed) else "met")
        late = figures.rows.get((case, "frame_phase_error"))
        cells.append(duration(late["max"]) if late else "")
        rows.append(cells)
    where = documents["dc"]["environment"]
    return [f"Virtual time, the same on every machine: {build_of(where)}.", ""] + table(
        [("line", "l"), ("to OP", "r"), ("SYNC0 against the reference's, peak", "r"), ("RMS", "r"),
         ("phase of the grid, largest error", "r"), ("aims", "l"), ("frames late by up to", "r")], rows)


INTERPOLATIONS = {"path": "a path that is known", "curve": "a curve that is continued", "stream": "a stream, with its checks and limits"}


def interpolation(documents):
    figures = Figures(documents["trajectory"])
    counts = ("1", "8", "32", "128")
    rows = []
    for case in figures.cases("cost_per_axis"):
        kind, method, axes = re.fullmatch(r"(path|curve|stream)_(\w+)_(\d+)_axes", case).groups()
        if axes != "1":
            continue
        each = [figures.row(f"{kind}_{method}_{count}_axes", "cost_per_axis") for count in counts]
        aimed = each[counts.index("32")]
        aim = f"{limits(aimed)['p50']:.0f} ns: {verdict(aimed)}" if limits(aimed) else ""
        rows.append([INTERPOLATIONS[kind], method, *(f"{row['p50']:.1f} ns" for row in each), f"{aimed['p99']:.1f} ns",
                     f"{aimed['ratio_p50']:.2f}", aim])
    rows.sort(key=lambda row: list(INTERPOLATIONS.values()).index(row[0]))
    return where_from(documents["trajectory"]) + table(
        [("per axis and cycle", "l"), ("method", "l"), ("1 axis", "r"), ("8 axes", "r"), ("32 axes", "r"), ("128 axes", "r"),
         ("32 axes, p99", "r"), ("times bare cubics", "r"), ("aim, 32 axes", "l")], rows)


def profiles(documents):
    figures = Figures(documents["trajectory"])
    rows = []
    for case in figures.cases("time_per_plan"):
        row = figures.row(case, "time_per_plan")
        failures = figures.row(case, "failures")
        rows.append([case.split("_")[1], f"{row['n']:,}", *(figures.time(case, "time_per_plan", key) for key in ("p50", "p99", "p999", "max")),
                     figures.time(case, "slowest_repeated", "max"), f"{failures['max']:.0f}", f"{duration(limits(row)['p50'])}: {verdict(row)}"])
    return table([("axes", "r"), ("problems", "r"), ("p50", "r"), ("p99", "r"), ("p99.9", "r"), ("max", "r"),
                  ("the slowest planned again, max", "r"), ("failures", "r"), ("aim of the median", "l")], rows)


PATH_COSTS = {
    "short_segments_3_axes": ("planning, a segment of 0.1 mm, 3 axes", "cost_per_segment"),
    "moves_of_a_delta": ("planning, a move of a delta", "cost_per_move"),
    "moves_of_a_scara": ("planning, a move of a SCARA", "cost_per_move"),
    "cycle_6_axes": ("the cycle's part, 6 axes", "cost_per_cycle"),
    "cycle_delta": ("the cycle's part, a delta", "cost_per_cycle"),
    "cycle_scara": ("the cycle's part, a SCARA", "cost_per_cycle"),
}


def path(documents):
    figures = Figures(documents["path"])
    rows = []
    for case, (what, metric) in PATH_COSTS.items():
        row = figures.row(case, metric)
        aimed = [f"{key.replace('p999', 'p99.9')} {duration(limit * TO_NS[row['unit']])}: {verdict(row, key)}" for key, limit in limits(row).items()]
        rows.append([what, *(figures.time(case, metric, key) for key in ("p50", "p99", "p999", "max")), "; ".join(aimed)])
    return where_from(documents["path"]) + table(
        [("", "l"), ("p50", "r"), ("p99", "r"), ("p99.9", "r"), ("max", "r"), ("aims", "l")], rows)


def path_durations(documents):
    figures = Figures(documents["path"])
    rows = []
    for case in figures.cases("planned"):
        row = figures.row(case, "longer_than_optimum")
        seconds = lambda metric: f"{figures.row(case, metric)['p50'] / 1e3:.4f} s"
        rows.append([case.replace("_", " "), seconds("planned"), seconds("optimum"), seconds("bound_without_jerk"),
                     f"{row['p50']:.1f} %: {verdict(row)}"])
    most = lambda case, metric: f"{figures.row(case, metric)['max']:.1f} %"
    text = [f"The numeric optimum is up to {most('straight_lines', 'optimum_above_least_duration')} above the least duration of straight lines, "
            f"and up to {most('twenty_reference_paths', 'optimum_above_bound')} above the bound without jerk on these paths."]
    if ("twenty_reference_paths", "finer_off_optimum") in figures.rows:
        text[0] += f" With twice as many intervals it changes by {most('twenty_reference_paths', 'finer_off_optimum')} at most."
    return text + [""] + table([("path", "l"), ("planned", "r"), ("numeric optimum", "r"), ("bound without jerk", "r"),
                                ("longer than the numeric optimum, aim 5 %", "l")], rows)


def sure_ratio(row, places=2):
    """The ratio of the medians, with the 95 % interval of those of the turns."""
    text = f"{row['ratio_p50']:.{places}f}"
    turns = row.get("ratio_turns")
    return text + (f" ({turns['low']:.{places}f} to {turns['high']:.{places}f})" if turns else "")


def roundtrip(documents):
    figures = Figures(documents["roundtrip"])
    rows = []
    for case in figures.cases("round_trip"):
        size, kind = re.fullmatch(r"(\d+)_bytes_(\w+)", case).groups()
        port = figures.row(case, "round_trip")
        common = figures.rows.get((case, "against_packet_socket"))
        rows.append([size, kind.replace("_", " "), figures.time(case, "bare_round_trip"), figures.time(case, "round_trip"),
                     figures.time(case, "round_trip", "p99"), f"{sure_ratio(port)}: {verdict(port)}",
                     f"{sure_ratio(common)}: {verdict(common)}" if common else ""])
    return where_from(documents["roundtrip"]) + table(
        [("bytes", "r"), ("port", "l"), ("bare loop p50", "r"), ("port p50", "r"), ("p99", "r"),
         ("ratio, 95 % interval, aim 1.05", "l"), ("ratio to the loop of `send` and `recv`, aim 0.9", "l")], rows)


def stops_of_all_axes(figures):
    """Of `scale`; documents of earlier commits have no such figures."""
    rows = []
    for case in figures.cases("cycle_that_stops_all_axes"):
        axes, waits = re.fullmatch(r"(\d+)_axes(_and_requests_that_wait)?", case).groups()
        rows.append([axes, "10,000 requests, a move in each axis" if waits else "nothing", figures.time(case, "cycle_of_moving_axes"),
                     *(figures.time(case, "cycle_that_stops_all_axes", key) for key in ("p50", "p99")),
                     sure_ratio(figures.row(case, "cycle_that_stops_all_axes"), 1)])
    return ["", *table([("axes", "r"), ("what waits", "l"), ("master's part of a cycle while all axes move, p50", "r"),
                        ("of the cycle that stops all of them, p50", "r"), ("p99", "r"), ("ratio, 95 % interval", "l")],
                       rows)] if rows else []


def scale(documents):
    figures = Figures(documents["scale"])
    rows = []
    for case in figures.cases("frames_on_the_wire"):
        value = lambda metric: figures.row(case, metric)["p50"]
        cost = [figures.time(f"{case}_every_{cycle}_us", "master_part", key) for cycle in (125, 1000) for key in ("p50", "p99")]
        rows.append([case.removesuffix("_axes"), *cost, f"{value('frames_on_the_wire'):.1f} µs",
                     f"{value('way_through_the_line'):.1f} µs", f"{value('memory_of_the_master') / 1024:.1f} MiB"])
    return where_from(documents["scale"]) + table(
        [("axes", "r"), ("the master's part every 125 µs, p50", "r"), ("p99", "r"), ("every 1 ms, p50", "r"), ("p99", "r"),
         ("frames on the wire", "r"), ("way through the line", "r"), ("memory of the master", "r")], rows) + stops_of_all_axes(figures)


def scale_limits(documents):
    figures = Figures(documents["scale"])
    rows = [[case.removeprefix("every_").removesuffix("_us") + " µs",
             *(f"{figures.row(case, limit)['p50']:.0f}" for limit in ("limit_of_the_wire", "limit_of_this_machine", "limit_of_both"))]
            for case in figures.cases("limit_of_both")]
    return table([("cycle", "r"), ("axes on the wire", "r"), ("axes by this machine, of 256", "r"), ("both", "r")], rows)


def jitter(documents):
    figures = Figures(documents["jitter"])
    rows = []
    for case in figures.cases("wake_latency"):
        state, way = case.split("_", 1)
        has = lambda metric: (case, metric) in figures.rows
        rows.append([state, way.replace("_", " "), *(figures.time(case, "wake_latency", key) for key in ("p50", "p99", "p999", "max")),
                     f"{figures.row(case, 'missed_periods')['p50']:.0f}" if has("missed_periods") else "",
                     figures.time(case, "send_time", "p99") if has("send_time") else "",
                     figures.time(case, "arrival_period_off", "p99") if has("arrival_period_off") else ""])
    return where_from(documents["jitter"]) + table(
        [("", "l"), ("", "l"), ("wake-up p50", "r"), ("p99", "r"), ("p99.9", "r"), ("max", "r"), ("missed periods", "r"),
         ("sent, p99", "r"), ("arrival off the period, p99", "r")], rows)


def soak(documents):
    figures = Figures(documents["soak"])
    rows = []
    for metric in ("wake_latency_p50", "wake_latency_p99", "wake_latency_max", "whole_cycle_p50", "whole_cycle_p99",
                   "whole_cycle_max", "missed_periods", "resident_memory"):
        row = figures.row("8_axes", f"{metric}_in_last_third")
        show = duration(row["p50"]) if row["unit"] == "ns" else f"{row['p50']:.1f}" + (f" {row['unit']}" if row["unit"] != "1" else "")
        rows.append([metric.replace("_", " "), show, sure_ratio(row, 3)])
    cycles = figures.row("8_axes", "whole_cycle")["n"]
    missed = figures.row("8_axes", "missed_periods")["p50"]
    return where_from(documents["soak"]) + [f"{cycles:,} cycles, {missed:.0f} periods missed.", ""] + table(
        [("of a window", "l"), ("median of the last third", "r"), ("over that of the first, 95 % interval", "l")], rows)


READERS = {"fast_dds": "Fast DDS", "cyclone": "Cyclone DDS"}


def telemetry_case(case):
    """"8_axes_fast_dds": 8, Fast DDS."""
    axes, reader = re.fullmatch(r"(\d+)_axes_(\w+)", case).groups()
    return [axes, READERS.get(reader, reader.replace("_", " "))]


def telemetry(documents):
    figures = Figures(documents["telemetry"])
    rows = []
    for case in figures.cases("latency_p99"):
        row = lambda metric: figures.row(case, metric)
        lost, late, bridge, line = (row(metric) for metric in ("samples_and_batches_lost", "latency_p99", "memory_of_the_bridge", "memory_of_the_run"))
        rows.append([*telemetry_case(case), f"{row('cycles_received')['p50']:,.0f}", f"{lost['p50']:.0f}: {verdict(lost)}",
                     figures.time(case, "latency_p50"), f"{figures.time(case, 'latency_p99')}: {verdict(late)}",
                     duration(row("latency_max")["p50"] * TO_NS["us"]),
                     *(f"{row(metric)['p50']:.1f} %" for metric in ("bridge_cpu", "reader_cpu")),
                     f"{bridge['p50']:.0f} MiB: {verdict(bridge)}",
                     f"{line['p50']:.0f} MiB" + (f": {verdict(line)}" if limits(line) else "")])
    written = [f"{case.split('_')[0]} axes {figures.row(case, 'sample_per_axis')['p50']:.1f} ns ({verdict(figures.row(case, 'sample_per_axis'))})"
               for case in figures.cases("sample_per_axis")]
    return where_from(documents["telemetry"]) + table(
        [("axes", "r"), ("reader", "l"), ("cycles received in a run, median", "r"), ("lost in all runs", "r"), ("latency p50", "r"), ("p99, aim 2 ms", "r"),
         ("max of all runs", "r"), ("bridge, of a processor", "r"), ("reader", "r"), ("memory of the bridge, aim 128 MiB", "r"),
         ("of the run, aim 48 MiB with 8 axes", "r")], rows) + [
        "", f"What the cycle itself does for it, a sample and its axis in one ring, p50 per axis, aim 20 ns: {', '.join(written)}."]


def telemetry_cost(documents):
    figures = Figures(documents["telemetry"])
    rows = []
    for case in figures.cases("cycle_cost_p999_with_over_without"):
        percent = lambda metric: figures.row(case, metric)["p50"] / 100
        upper = figures.row(case, "cycle_cost_p999_upper_end_of_95_interval")
        more = figures.row(case, "missed_periods_more_lower_end_of_95_interval")
        rows.append([*telemetry_case(case), str(upper["n"]), f"{percent('cycle_cost_p999_with_over_without'):.2f}",
                     f"{upper['p50'] / 100:.2f}: {verdict(upper)}", f"{percent('wake_latency_p999_with_over_without'):.2f}",
                     f"{percent('wake_latency_p999_upper_end_of_95_interval'):.2f}",
                     *(f"{figures.row(case, metric)['p50']:.0f}" for metric in ("missed_periods_with", "missed_periods_without")), verdict(more)])
    return table([("axes", "r"), ("reader", "l"), ("pairs", "r"), ("p99.9 of the cycle's cost with over without, median", "r"),
                  ("upper end of the 95 % interval, aim 1.05", "r"), ("the same of the wake-up latency", "r"), ("upper end", "r"),
                  ("missed periods of a run with", "r"), ("without", "r"), ("not more with, within the interval", "l")], rows)


def aims(documents):
    rows = []
    for name in sorted(documents):
        aimed = [(row, key) for row in documents[name]["results"] for key in limits(row)]
        if not aimed:
            continue
        missed = [f"`{row['case']}`" + (" (p99.9)" if key == "p999" else "")
                  for row, key in aimed if verdict(row, key) != "met"]
        rows.append([f"`{name}`", str(len(aimed)), str(len(aimed) - len(missed)), ", ".join(missed)])
    return table([("program", "l"), ("aims", "r"), ("met", "r"), ("missed by", "l")], rows)


def missed(documents):
    """Periods that `run` misses, beside a loop that is awake as long and beside cyclictest."""
    if "missed" not in documents:
        return ["Not measured yet: `scripts/bench_tables.py --run missed` on an idle machine fills this table."]
    figures = Figures(documents["missed"])
    run = figures.row("run_8_axes", "missed_periods")

    def over(floor, row):
        return sure_ratio(row) if floor["p50"] > 0 else ""  # nothing is a multiple of 0

    rows = [["`driveline run`, 8 axes", f"{run['p50']:.0f}", f"{run['max']:.0f}", ""]]
    for name, case, metric in (("bare loop, awake as long", "bare_loop_as_long_awake", "missed_periods"),
                               ("`cyclictest`", "cyclictest", "missed_periods_over_cyclictest")):
        if (case, "missed_periods") not in figures.rows:
            continue
        floor = figures.row(case, "missed_periods")
        rows.append([name, f"{floor['p50']:.0f}", f"{floor['max']:.0f}", over(floor, figures.row("run_8_axes", metric))])
    awake = figures.time("run_8_axes", "awake_per_period")
    return where_from(documents["missed"]) + [f"{run['n']} turns of each; `run` was awake for {awake} of each 125 µs.", ""] + table(
        [("in a turn", "l"), ("missed periods, median", "r"), ("largest", "r"), ("`run` over it, 95 % interval", "l")], rows)


def headline(documents):
    """What the page that everybody reads first says: the cycle of an idle machine beside what is usually measured."""
    cycle, jitter = Figures(documents["cycle"]), Figures(documents["jitter"])
    ways = [("driveline, as `run` waits", "idle_cycle"), ("`cyclictest`, same core and priority", "idle_cyclictest"),
            ("a bare loop of `clock_nanosleep` and `send`", "idle_bare_loop")]
    rows = []
    for name, case in ways:
        if (case, "wake_latency") not in jitter.rows:
            continue
        sent = (case, "send_time") in jitter.rows
        rows.append([name, *(jitter.time(case, "wake_latency", key) for key in ("p50", "p99", "p999", "max")),
                     jitter.time(case, "send_time", "p99") if sent else "",
                     f"{jitter.row(case, 'missed_periods')['p50']:.0f} of {jitter.row(case, 'wake_latency')['n']:,}"
                     if (case, "missed_periods") in jitter.rows else ""])
    part = [f"{axes} axes {cycle.time(f'paced_{axes}_axes', 'master_part')}" for axes in (8, 32, 100)]
    return where_from(documents["jitter"]) + table(
        [("every 125 µs", "l"), ("woken late, p50", "r"), ("p99", "r"), ("p99.9", "r"), ("max", "r"), ("sent late, p99", "r"),
         ("missed periods", "r")], rows) + ["", f"The master's part of a cycle, setpoints and frames of all axes, p50: {', '.join(part)}."]


# Name in the marker: function, programs whose documents it needs.
TABLES = {
    "aims": (aims, None),  # all that have aims
    "can": (can, []),  # without its document it says so
    "cycle": (cycle, ["cycle"]),
    "dc": (dc, ["dc"]),
    "drive": (drive, ["drive"]),
    "eoe": (eoe, ["eoe"]),
    "eoe_cost": (eoe_cost, ["eoe"]),
    "esc": (esc, ["esc"]),
    "headline": (headline, ["cycle", "jitter"]),
    "interpolation": (interpolation, ["trajectory"]),
    "jitter": (jitter, ["jitter"]),
    "master_cost": (master_cost, ["master_cost"]),
    "missed": (missed, []),  # without its document it says so
    "path": (path, ["path"]),
    "path_durations": (path_durations, ["path"]),
    "profiles": (profiles, ["trajectory"]),
    "roundtrip": (roundtrip, ["roundtrip"]),
    "scale": (scale, ["scale"]),
    "scale_limits": (scale_limits, ["scale"]),
    "soak": (soak, ["soak"]),
    "startup": (startup, ["startup"]),
    "startup_memory": (startup_memory, ["startup"]),
    "telemetry": (telemetry, ["telemetry"]),
    "telemetry_cost": (telemetry_cost, ["telemetry"]),
    "turnaround": (turnaround, ["turnaround"]),
    "wake": (wake, ["wake"]),
}
