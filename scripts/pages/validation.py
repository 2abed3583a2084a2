"""results/validation.md from the records of scripts/validation, a folder with release/ and, if they were run, asan/.

release/*.jsonl and asan/*.jsonl have one line per property (tests/validation) or scene of the oracle (tests/oracle);
release/*.trace.json is `vrda trace --json` of each job in jobs/validation, and of a coarse grid of the generic knee.
"""
import json
import pathlib
import sys
import tomllib

KNEE = "knee-trace.trace.json"
JOBS = pathlib.Path(__file__).resolve().parents[2] / "jobs" / "validation"
ENDINGS = {"stable": "in equilibrium", "no_contact": "passed through: no contact along the push direction",
           "no_clearance": "interpenetrating", "iteration_limit": "no equilibrium within max_steps"}


def records(folder):
    """All JSON lines of a folder: properties by seed, scenes of the oracle by name."""
    lines = [json.loads(line) for file in sorted(folder.glob("*.jsonl")) for line in file.read_text().splitlines()]
    properties = sorted((line for line in lines if "test" in line), key=lambda line: (line["seed"], line["test"], line["scene"]))
    oracle = sorted((line for line in lines if "oracle" in line), key=lambda line: (line["seed"], line["oracle"]))
    return properties, oracle


def number(value):
    """Three significant digits; "none" if missing."""
    return "none" if value is None else f"{value:.3g}"


def fixed(value, digits):
    """Fixed number of decimals, without a negative zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def table(headings, right, rows):
    """Markdown lines; the last `right` columns are right-aligned."""
    n_left = len(headings) - right
    cells = [headings] + [[str(cell) for cell in row] for row in rows]
    lines = [f"| {' | '.join(row)} |" for row in cells]
    lines.insert(1, "|" + "---|" * n_left + "---:|" * right)
    return lines


def property_rows(properties):
    """One row per property: scene, claim and measurement."""
    for each in properties:
        outcomes = ", ".join(f"{name} {count}" for name, count in each["outcomes"].items())
        yield (each["scene"], each["claim"], outcomes, each["measure"], f"{each['cases']:,}", each["seed"],
               number(each["worst"]), number(each["allowed"]), each["failures"])


def sanitized_line(release, sanitized):
    """Summary of the run under the sanitizers: a row passes if its record is equal."""
    if not sanitized:
        return "Not yet run under address and undefined-behaviour checks: `scripts/validation --preset asan`."
    held = [each for each in release if each in sanitized]
    line = (f"Also passed under address and undefined-behaviour checks (`scripts/validation --preset asan`), with equal numbers: "
            f"{len(held)} of {len(release)} rows of the two tables.")
    rest = [each.get("test", each.get("oracle")) for each in release if each not in sanitized]
    return line + (f" Failed, or with different numbers: {', '.join(rest)}." if rest else "")


def collect(folder):
    """Properties and scenes of the oracle, those that sanitizers repeated, and the summary of each trace."""
    properties, oracle = records(folder / "release")
    if not properties:
        sys.exit(f"validation: found no record of a property in {folder}/release, wanted at least one")
    traces = {}
    for file in sorted((folder / "release").glob("*.trace.json")):
        traced = json.loads(file.read_text())
        if file.name == KNEE:
            statuses = [each["status"] for each in traced["searches"]]
            traces[file.name] = {"title": traced["title"], "all": traced["all"], "searches": len(statuses), "stable": statuses.count("stable")}
        else:
            (search,) = [each for each in traced["searches"] if each["node"] != "spine_probe"]
            initial = tomllib.loads((JOBS / f"{file.name.removesuffix('.trace.json')}.toml").read_text())["moving"]["initial"]
            traces[file.name] = {"title": traced["title"], "initial": initial, **{key: search[key] for key in ("status", "in_contact", "by_kind", "end")}}
    return {"properties": properties, "oracle": oracle, "sanitized": [each for lines in records(folder / "asan") for each in lines], "traces": traces}


def job_section(file_name, search):
    """Section of a job: summary of its search, and its image."""
    name = file_name.removesuffix(".trace.json")
    initial, end, kinds = search["initial"], search["end"], search["by_kind"]
    start = initial["translation_mm"]
    return "\n".join([
        f"### {search['title']}", "",
        f"![{search['title']}, before and after](pictures/validation-{name}.png)", "",
        f"`jobs/validation/{name}.toml`: from ({start[0]:g}, {start[2]:g}) mm perpendicular to the push, rotated by {initial['theta_deg']:g} degrees, "
        f"to ({fixed(end['translation_mm'][0], 2)}, {fixed(end['translation_mm'][2], 2)}) mm, rotated by {fixed(end['theta_deg'], 1)} degrees, "
        f"moves in contact {search['in_contact']}, translations {kinds['translate']}, rotations {kinds['rotate']}. "
        f"End: `{search['status']}`, {ENDINGS[search['status']]}.", ""])


def knee_section(traced):
    """Section of the knee's grid: totals over all searches."""
    whole = traced["all"]
    kinds = ", ".join(f"{name} {count:,}" for name, count in whole["by_kind"].items())
    return "\n".join([
        "### Generic knee", "",
        "![Generic knee at 30 degrees of flexion, before and after](pictures/validation-knee-trace.png)", "",
        f"`jobs/knee-generic-contact.toml` in steps of 10 degrees of flexion and 5 of varus, with `--trace`: {traced['searches']} searches, {traced['stable']} `stable`; "
        f"{whole['moves']:,} moves ({kinds}), {whole['in_contact']:,} of them in contact, {whole['cycles']:,} cycles found, "
        f"{whole['blocked_trials']:,} trials blocked. Image: start and end of the spine's search at 30 degrees.", ""])


def page(numbers, stamp):
    """The page."""
    properties, oracle = numbers["properties"], numbers["oracle"]
    lines = ["# Validation\n", "Written by `scripts/validation`. Each row is a test with random parameters from a fixed seed; it failed if `failures`\n"
             "is not 0. The claims are those of chapters 3 and 4 of the thesis.\n", stamp + "\n", "\n".join(table(
                 ["scene", "claim of the thesis", "outcomes", "measure", "cases", "seed", "worst", "allowed", "failures"], 5, property_rows(properties))),
             f"\n{sum(each['cases'] for each in properties):,} cases, {sum(each['failures'] for each in properties):,} failures. "
             + sanitized_line(properties + oracle, numbers["sanitized"]), "\n## The scenes, before and after\n",
             "Shown upside down: the moving object (blue) is pushed down onto the reference. Right: end of the search.\n"]
    for name, traced in sorted(numbers["traces"].items()):
        lines.append(knee_section(traced) if name == KNEE else job_section(name, traced))
    if oracle:
        lines += ["## Collisions against FCL\n",
                  "The same poses tested by FCL, by the standard triangle test and by this project; if any two differ, a third measure in extended\n"
                  "precision decides which is wrong. This project's test may be wrong only within 1e-9 mm of contact, otherwise the row fails.\n",
                  "\n".join(table(
                      ["objects", "poses", "seed", "colliding", "within 1e-3 mm of contact", "answers differ", "largest distance from contact there, mm",
                       "FCL wrong", "standard test wrong", "VRDA wrong"], 9,
                      [(each["oracle"], f"{each['poses']:,}", each["seed"], f"{each['colliding']:,}", f"{each['near']:,}", each["disagreeing"],
                        number(each["farthest_mm"]), each["fcl_wrong"], each["textbook_wrong"], each["we_wrong"]) for each in oracle])),
                  f"\n{sum(each['poses'] for each in oracle):,} poses."]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.stdout.write(page(collect(pathlib.Path(sys.argv[1])), "Solver: of the test."))
