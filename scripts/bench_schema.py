"""What a document of a program in bench/ must have: problem_of(document) is a sentence about what it lacks, or nothing."""

TEXT, FLAG, LIST = (str,), (bool,), (list,)
NUMBER = (int, float)
ENVIRONMENT = {"kernel": TEXT, "kernel_build": TEXT, "kernel_options": TEXT, "cpu": TEXT, "cores": NUMBER, "isolated_cpus": TEXT,
               "governor": TEXT, "interfaces": LIST, "compiler": TEXT, "commit": TEXT, "build": TEXT, "virtual_machine": FLAG,
               "date": TEXT, "other_load": NUMBER, "stolen_load": NUMBER, "quick": FLAG, "short": FLAG}
ROW = {"case": TEXT, "metric": TEXT, "unit": TEXT, "n": NUMBER, "p50": NUMBER, "p99": NUMBER, "p999": NUMBER, "max": NUMBER}
# What stands together or not at all.
TOGETHER = [{"against": TEXT, "ratio_p50": NUMBER, "ratio_p999": NUMBER}, {"aim": TEXT, "met": FLAG}]
TURNS = {"turns": NUMBER, "mean": NUMBER, "low": NUMBER, "high": NUMBER}
HISTOGRAM = {"bin_us": NUMBER, "deadline_us": NUMBER, "missed": NUMBER, "bins": LIST, "per_decade": NUMBER, "unresolved": (dict,),
             "log_bins": LIST}
RAN = {"thread": TEXT, "us": NUMBER}
COURSE = {"window_s": NUMBER, "p50": LIST, "p99": LIST, "max": LIST}


def lacking(part, keys):
    for key, kinds in keys.items():
        # A flag is a number to Python.
        if not isinstance(part.get(key), kinds) or (isinstance(part[key], bool) and kinds != FLAG):
            return f'"{key}"'
    return None


def histogram_problem(row):
    histogram = row["histogram"]
    if key := lacking(histogram, HISTOGRAM):
        return f"a distribution has no {key}"
    total = sum(count for _, count in histogram["bins"])
    missed = sum(count for us, count in histogram["bins"] if us >= histogram["deadline_us"])
    if (total, missed) != (row["n"], histogram["missed"]):
        return f"a distribution of {total} measurements, {missed} of them missed, for {row['n']} and {histogram['missed']}"
    in_bars = histogram["unresolved"].get("count", 0) + sum(count for _, count in histogram["log_bins"])
    if in_bars != row["n"]:
        return f"logarithmic bars of {in_bars} measurements for {row['n']}"
    return None


def row_problem(row):
    if key := lacking(row, ROW):
        return f"no {key}"
    for keys in TOGETHER:
        if keys.keys() & row.keys() and (key := lacking(row, keys)):
            return f"no {key}"
    if "ratio_turns" in row and (key := lacking(row["ratio_turns"], TURNS)):
        return f"turns without {key}"
    if "over_time" in row:
        if key := lacking(row["over_time"], COURSE):
            return f"a course without {key}"
        if len({len(row["over_time"][key]) for key in ("p50", "p99", "max")}) != 1:
            return "a course whose windows differ"
    for one in row.get("ran_instead", []):
        if key := lacking(one, RAN):
            return f"a thread that ran without {key}"
    return histogram_problem(row) if "histogram" in row else None


def problem_of(document):
    if not isinstance(document, dict) or lacking(document, {"bench": TEXT, "environment": (dict,), "results": LIST}):
        return "printed no document"
    if key := lacking(document["environment"], ENVIRONMENT):
        return f"has no {key} in its environment"
    for row in document["results"]:
        if problem := row_problem(row):
            return f"printed {problem}: {row.get('case')} {row.get('metric')}"
    return None
