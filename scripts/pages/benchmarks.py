"""results/benchmarks.md: scripts/benchmarks.template.md filled from Google Benchmark's JSON.

usage: python3 scripts/pages/benchmarks.py FILE.json...      prints the page, for scripts/bench --quick and --filter
A benchmark named room/what/case is a row of the room's table; its counters are columns. Of repetitions the median is used.
The room "rates" is kept in results/records/rates.json by `scripts/bench rates`.
Below the room "scaling": the exponent of time over the counter "triangles"; below "growth": of time and memory over both counters.
Exit code 1 if a benchmark reported an error or none ran.
"""
import json
import math
import os
import pathlib
import platform
import re
import subprocess
import sys

# What Google Benchmark appends to a name for its own settings.
SETTING = re.compile(r"/(real_time|process_time|manual_time|(iterations|repeats|threads|min_time|min_warmup_time):[^/]+)")
# Fields of a run that are not counters.
OWN_FIELDS = {
    "name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions", "repetition_index",
    "threads", "iterations", "real_time", "cpu_time", "time_unit", "aggregate_name", "aggregate_unit", "label",
    "error_occurred", "error_message", "items_per_second", "bytes_per_second",
}
RATES = pathlib.Path(__file__).resolve().parents[2] / "results/records/rates.json"
SECONDS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


def machine():
    """Cores and processor model; no host name."""
    model = platform.machine()
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
        model = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), model)
    except OSError:
        pass
    n_cores = len(os.sched_getaffinity(0))
    return f"{n_cores} core{'s' if n_cores != 1 else ''}, {model}"


def compiler():
    """Name and version of the presets' compiler."""
    try:
        return subprocess.run(["g++", "--version"], capture_output=True, text=True, check=True).stdout.splitlines()[0]
    except (OSError, subprocess.CalledProcessError):
        return "unknown compiler"


def three_digits(value):
    """Three significant digits, thousands separated, no exponent: 12,300; 0.0457."""
    if value == 0:
        return "0"
    if abs(value) >= 100:
        return f"{float(f'{value:.3g}'):,.0f}"
    digits = 2
    while digits < 12 and abs(value) < 10 ** (1 - digits + 1):
        digits += 1
    return f"{float(f'{value:.3g}'):.{digits}f}".rstrip("0").rstrip(".")


def time_text(seconds):
    """A duration in the unit that keeps it between 1 and 1000."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{three_digits(seconds / size)} {unit}"
    return f"{three_digits(seconds / 1e-9)} ns"


def counter_text(name, value):
    """Shares in per cent, other counters as numbers."""
    return f"{100 * value:.1f} %" if name.endswith("share") else three_digits(value)


def row(name, seconds_of_one, **counters):
    """One entry in the form of Google Benchmark."""
    return {"name": name, "run_name": name, "run_type": "iteration", "repetitions": 1, "threads": 1, "iterations": 1,
            "real_time": seconds_of_one, "cpu_time": seconds_of_one, "time_unit": "s", **counters}


def write_rows(path, rows):
    pathlib.Path(path).write_text(json.dumps({"benchmarks": rows}, indent=1))


def chosen_runs(runs):
    """One run per benchmark: the median if repeated."""
    medians = {run["run_name"] for run in runs if run.get("aggregate_name") == "median"}
    return [run for run in runs if run.get("aggregate_name") == "median" or
            (run.get("run_type") != "aggregate" and run["run_name"] not in medians)]


def parts(run):
    """room, what, case of a run; `what` may contain slashes."""
    names = SETTING.sub("", run["run_name"]).split("/")
    return names[0], "/".join(names[1:-1]) or names[-1], names[-1] if len(names) > 2 else ""


def seconds(run):
    """Wall-clock time of one iteration."""
    return run["real_time"] * SECONDS[run.get("time_unit", "ns")]


def power(runs, size, value=seconds):
    """Least-squares slope of log value over log size, and that from the first size to the last; None with fewer than two sizes."""
    points = [(math.log(run[size]), math.log(value(run))) for run in runs if run.get(size, 0) > 0]
    if len({x for x, _ in points}) < 2:
        return None
    x_mean, y_mean = (sum(values) / len(points) for values in zip(*points))
    slope = sum((x - x_mean) * (y - y_mean) for x, y in points) / sum((x - x_mean) ** 2 for x, _ in points)
    (x_first, y_first), (x_last, y_last) = min(points), max(points)
    return slope, (y_last - y_first) / (x_last - x_first)


def power_line(runs):
    """Of the time over triangles."""
    powers = power(runs, "triangles")
    return ["", "Time grows with triangles to the power {:.2f} (least squares of the logarithms; "
                "{:.2f} from the first size to the last).".format(*powers)] if powers else []


def growth_lines(runs):
    """Of time and memory over triangles and attitudes."""
    lines = []
    for size in ("triangles", "attitudes"):
        of_size = [run for run in runs if parts(run)[1] == size]
        time, memory = power(of_size, size), power(of_size, size, lambda run: run["peak memory, MB"])
        if time:
            lines += ["", f"With {size}, time grows to the power {time[0]:.2f}, memory to the power {memory[0]:.2f} (least squares of the logarithms)."]
    return lines


def table(room, runs):
    """Markdown table of one room."""
    counters = list(dict.fromkeys(
        name for run in runs for name, value in run.items()
        if name not in OWN_FIELDS and isinstance(value, (int, float))))
    if any("items_per_second" in run for run in runs):
        counters.insert(0, "items_per_second")
    headings = ["benchmark", "case", "time"] + [name.replace("_per_second", "/s").replace("_", " ") for name in counters]
    lines = [f"## {room}", "", f"| {' | '.join(headings)} |", "|---|---|" + "---:|" * (len(headings) - 2)]
    for run in runs:
        _, what, case = parts(run)
        cells = [what, case, time_text(seconds(run))]
        cells += [counter_text(name, run[name]) if name in run else "" for name in counters]
        lines.append(f"| {' | '.join(cells)} |")
    if room == "scaling":
        lines += power_line(runs)
    if room == "growth":
        lines += growth_lines(runs)
    if "old" in runs[0]:
        lines += ["", f"Old: commit {runs[0]['old']}, measured alternately in the same minutes; `times faster` is the median of the ratios."]
    return "\n".join(lines)


def collect(*files):
    """Machine, compiler and the chosen runs, without what depends on the host's name; exits with 1 if a benchmark failed or none ran."""
    runs = [run for path in files for run in json.loads(pathlib.Path(path).read_text()).get("benchmarks", [])]
    failed = [run for run in runs if run.get("error_occurred")]
    for run in failed:
        print(f"bench: {run['name']} failed: {run.get('error_message', 'no reason given')}", file=sys.stderr)
    chosen = chosen_runs([run for run in runs if not run.get("error_occurred")])
    if not failed and not chosen:
        print(f"bench: found no benchmark in {' '.join(map(str, files))}, wanted at least one", file=sys.stderr)
    if failed or not chosen:
        sys.exit(1)
    return {"machine": machine(), "compiler": compiler(), "repeated": max(run.get("repetitions", 1) for run in chosen), "runs": chosen}


def page(numbers, stamp, has_rates=True):
    """The page."""
    rooms, runs = {}, numbers["runs"]
    for run in runs + (json.loads(RATES.read_text())["benchmarks"] if has_rates and RATES.is_file() else []):
        rooms.setdefault(parts(run)[0], []).append(run)
    template = (pathlib.Path(__file__).parents[1] / "benchmarks.template.md").read_text()
    return template.format(
        machine=numbers["machine"], compiler=numbers["compiler"], stamp=stamp, tables="\n\n".join(table(room, of) for room, of in rooms.items()),
        repetitions="one measurement each" if numbers["repeated"] == 1 else f"median of {numbers['repeated']} measurements")


if __name__ == "__main__":
    sys.stdout.write(page(collect(*sys.argv[1:]), "Not recorded.", has_rates=False))
