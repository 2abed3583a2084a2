"""results/calibration.md from the reports of scripts/calibration."""
import json

METHODS = ("stage", "tracker", "eye", "bodies")
PARTS = ("part", "name", "unit", "n", "within", "rms_error", "mean_half_width_95")
# Rows of the other methods: method, words, part, names.
OTHERS = (("eye", "distortion, by eye", "distortion", ("left.k1", "left.centre_x", "left.pixel_aspect")), ("eye", "leg, by eye", "leg",
    ("leg.shift_x", "leg.turn_x")),
          ("bodies", "ipd, from the rectangles", "ipd", ("ipd",)), ("bodies", "femur", "femur", ("femur.shift_x",)), ("bodies", "tibia", "tibia",
          ("tibia.shift_x",)))


def summary(report):
    """Every number's coverage, error and interval, with four significant digits."""
    four = lambda value: float(f"{value:.4g}") if isinstance(value, float) else value
    targets = {when: {unit: {key: four(value) for key, value in found.items()} for unit,
        found in report["targets"][when].items()} for when in ("before", "after")}
    return {"benches": report["benches"], "refused": report["refused"], "errors": report["targets"]["n"], "targets": targets,
            "numbers": [[four(number[part]) for part in PARTS] for number in report["numbers"]]}


def collect(folder):
    """The summary of each method, and of the sample."""
    return {method: summary(json.loads((folder / f"{method}.json").read_text(encoding="utf-8"))) for method in (*METHODS, "sample")}


def number(value):
    """Two significant digits."""
    return f"{value:.2g}"


def rows_of(rows, wanted=lambda part, name: True, words=None):
    """Table rows: part, number, coverage, error, half width."""
    for part, name, unit, n, within, rms, half in rows:
        if wanted(part, name):
            yield f"| {words or part} | {name} | {100 * within / n:g} % | {number(rms)} | {number(half)} {unit} |"


def coverage(rows):
    """Smallest and largest share of benches whose interval contains the true value."""
    shares = [100 * within / n for _, _, _, n, within, _, _ in rows]
    return f"{min(shares):g} to {max(shares):g} %"


def targets_rows(words, targets):
    """Overlay errors before and after."""
    for when in ("before", "after"):
        mm, minutes = targets[when]["mm"], targets[when]["arc_min"]
        yield "| " + " | ".join([words, when] + [f"{mm[key]:.2f} mm, {minutes[key]:.1f}'" for key in ("median", "p90", "largest")]) + " |"


def page(n, stamp):
    """The page."""
    stage, tracker = n["stage"], n["tracker"]
    head = "| part | number | within | rms error | half width |\n|---|---|---:|---:|---:|"
    refused = sum(n[method]["refused"] for method in METHODS)
    lines = ["# Accuracy of the calibration\n",
             f"Written by `scripts/calibration`: `vrda-player calibrate all --virtual --headless --benches {stage['benches']}` with each method, the whole procedure on virtual benches, seeds from 1, with\n"
             "simulated operators and the keys and samples of a real bench. Noise: 0.5 px in each coordinate of an alignment, 0.1 mm and 0.03 degrees of the tracker, 0.1 mm of the position of the tip,\n"
             "0.1 mm of rulers, 0.5 mm of the pupillometer, 1 mm of distances between landmarks; pincushion distortion, angle of the rails 90 degrees with a standard deviation of 0.3 degrees, partly\n"
             f"visible displays. Benches that the program refused: {refused}.\n", stamp + "\n",
             f"Overlay error at 20 points in 160 x 240 x 120 mm about the knee, for both eyes ({stage['errors']:,} errors), across the line of sight at the knee's distance:\n",
             "| head | | median | 9 of 10 within | largest |\n|---|---|---:|---:|---:|",
             *targets_rows("parallax stage", stage["targets"]), *targets_rows("body on the display", tracker["targets"]),
             "\n\"Before\": nominal eyes and optics, the eyes placed by a tape measure (10 mm, whole degrees), with the true table, leg and scale.\n",
             f"Coverage of the stated 95 % interval (target: 90 to 98 %; found: {coverage(stage['numbers'])} with the stage, {coverage(tracker['numbers'])} with a body on the display), root mean\n"
             "square error, and mean half width of the interval. With the parallax stage:\n", head, *rows_of(stage["numbers"]),
             "\nWith a body on the display, only different parts:\n", head, *rows_of(tracker["numbers"], lambda part, _: part in ("head", "leg")),
             "\n## Other methods\n",
             f"By eye (`distortion = \"adjust\"`, `model = \"adjust\"`, with the stage): coverage of every number {coverage(n['eye']['numbers'])}. Two bodies without a pupillometer\n"
             f"(`leg = \"two-bodies\"`, `pupillometer = false`, with a body on the display, points of `jobs/bench-desk.toml`): {coverage(n['bodies']['numbers'])}.\n", head]
    for method, words, part, names in OTHERS:
        lines += rows_of(n[method]["numbers"], lambda one, name: one == part and name in names, words)
    lines.append("\nWith translation steps of 0.5 mm for adjustment by eye the coverage was only 87.5 %: three adjusted poses were often rounded to the same number, whose spread is zero. The step is now 0.1 mm. Three adjusted grids\n"
                 "span at most two directions of the eight numbers, so the covariance has the shape of that of a fit to the nodes and the size of the spread. The simulated operator adjusts with 0.5 px of noise\n"
                 "at each node, and places a model with 0.5 px of noise at 100 mm; the accuracy of a person is unknown.")
    return "\n".join(lines) + "\n"
