"""results/truth.md from the scores of scripts/truth_scores."""
import math

from pages.tables import table

COORDINATES = (("flexion", "flexion, deg"), ("varus", "varus, deg"), ("internal", "internal, deg"), ("anterior", "anterior, mm"),
               ("proximal", "proximal, mm"), ("lateral", "lateral, mm"))
# The largest that each case may have: case, frames, measure, coordinate, limit, what to aim at.
LIMITS = (("tka-contact", "all", "rms", "varus", 0.5, None), ("tka-contact", "all", "rms", "internal", 2.1, None), ("tka-contact", "all", "rms", "anterior", 0.7, None),
          ("tka-contact", "all", "rms", "proximal", 0.35, None), ("tka-given", "all", "rms", "varus", 0.5, None), ("tka-given", "all", "rms", "proximal", 0.4, None),
          ("subtalar", "second_half", "shape", "varus", 1.13, 1.10), ("subtalar", "second_half", "shape", "internal", 1.48, 1.36))
TITLES = {"living-knee": "Knee in vivo, passive, 55 fibres"}  # other than in the record
CASES = ("tka-contact", "tka-fibres", "tka-given", "subtalar", "subtalar-axis", "living-knee")
# Of the patella: coordinate, label, the largest RMS it may have with the tibia as measured, and predicted with the tibia.
PATELLA = (("flexion", "flexion, deg", 3.0, 5.5), ("anterior", "anterior, mm", 1.3, None), ("proximal", "proximal, mm", 1.8, None),
           ("lateral", "lateral, mm", 0.7, None), ("rotation", "rotation, deg", None, None), ("tilt", "tilt, deg", None, None))
UNITS = {name: label.split(", ")[1] for name, label in COORDINATES}


def mean(values):
    """Of the joints of a case; None if one has no value."""
    return None if any(value is None for value in values) else math.fsum(values) / len(values)


def title_of(n, name):
    return TITLES.get(name, n[name]["title"])


def cell(case, name, text):
    """A coordinate that was given or is not scored has no number."""
    return "given" if name in case["not_scored"] else text


def fixed(value, digits=2):
    """Without a negative zero."""
    return "-" if value is None else f"{round(value, digits) + 0.0:.{digits}f}"


def of_case(case, part, measure, name):
    """Mean over the joints of a case."""
    return mean([joint["coordinates"][name][measure] for joint in case[part]])


def frames(case):
    """Frames scored and measured."""
    return f"{sum(joint['frames']['scored'] for joint in case['all'])} of {sum(joint['frames']['measured'] for joint in case['all'])}"


def found_rows(n):
    """RMS, in brackets bias and shape."""
    for name in (name for name in CASES if name in n):
        case = n[name]
        numbers = [cell(case, c, f"{fixed(of_case(case, 'all', 'rms', c))} ({fixed(of_case(case, 'all', 'bias', c))}; {fixed(of_case(case, 'all', 'shape', c))})")
                   for c, _ in COORDINATES]
        yield [title_of(n, name), case["given"], frames(case), *numbers]


def baseline_rows(n):
    """RMS of the measurement's mean and of its straight line."""
    for name in (name for name in CASES if name in n):
        case = n[name]
        yield [title_of(n, name), *(cell(case, c, f"{fixed(of_case(case, 'all', 'constant_rms', c))}; {fixed(of_case(case, 'all', 'line_rms', c))}")
                                for c, _ in COORDINATES)]


def half_rows(n):
    """With an offset from the first half: RMS and shape in the second, in brackets the constant's RMS."""
    for name in (name for name in CASES if name in n):
        case = n[name]
        yield [title_of(n, name), *(cell(case, c, f"{fixed(of_case(case, 'second_half', 'rms', c))}; {fixed(of_case(case, 'second_half', 'shape', c))} "
                                              f"({fixed(of_case(case, 'second_half', 'constant_rms', c))})") for c, _ in COORDINATES)]


def joint_rows(case):
    """Bias; shape of each joint."""
    for joint in case["all"]:
        yield [joint["name"], joint["frames"]["scored"],
               *(cell(case, c, f"{fixed(joint['coordinates'][c]['bias'])}; {fixed(joint['coordinates'][c]['shape'])}") for c, _ in COORDINATES)]


def patella_rows(case, limit_column):
    """RMS (bias; shape), what is allowed and the scatter of the measurement."""
    found = case["all"][0]["coordinates"]
    for name, label, *limits in PATELLA:
        numbers, limit = found[name], limits[limit_column]
        yield [label, f"{fixed(numbers['rms'])} ({fixed(numbers['bias'])}; {fixed(numbers['shape'])})", fixed(numbers["constant_rms"]),
               "-" if limit is None else f"{limit:.1f}", "-" if limit is None else "yes" if numbers["rms"] <= limit else "no"]


def patella(n):
    """The section of the patella."""
    parts = ["## Patella\n",
             "RMS (bias; shape) of the patella's coordinates over the frames of the passive trial. The data have no scanned pose: the first frame takes its\n"
             "place. It gives the slack lengths (2 % of strain in tendon and retinacula), the angle of the tendon and the offset of the cartilages, and is\n"
             "left out of the score. Rotation and tilt scatter by a degree in the data and tell little, so they have no limit.\n"]
    for limit_column, name in enumerate(("patella-given", "patella-predicted")):
        if name in n:
            parts += [f"{title_of(n, name)} ({n[name]['given']}); {frames(n[name])} frames:\n",
                      table(["coordinate", "RMS (bias; shape)", "scatter measured", "at most", "passed"], patella_rows(n[name], limit_column), 4)]
    return parts if len(parts) > 2 else []


def limit_rows(n):
    """Acceptance limits and results."""
    for name, part, measure, coordinate, limit, aim in LIMITS:
        if name not in n:
            continue
        value = of_case(n[name], part, measure, coordinate)
        at_most = f"{limit:.2f}" + ("" if aim is None else f", aim {aim:.2f}")
        yield [title_of(n, name) + f" ({', '.join(n[name]['not_scored'])} given{'; second half of the frames' if part == 'second_half' else ''})", f"{'RMS' if measure == 'rms' else measure} of {coordinate}, {UNITS[coordinate]}",
               at_most, fixed(value, 3), "yes" if value is not None and value <= limit else "no"]


def not_scored(n):
    """Frames without a pose, by reason."""
    lines = [f"- {title_of(n, name)}, {joint['name']}: {count} {reason}" for name, case in n.items() for joint in case["all"]
             for reason, count in joint["not_scored"].items()]
    return "\n".join(lines) or "None."


def page(n, stamp):
    """The page."""
    labels = [label for _, label in COORDINATES]
    missing = [name for name in CASES if name not in n]
    parts = ["# Measured joints\n",
             "Written by `scripts/truth`: joints whose motion was measured, solved by the equilibrium and scored by `vrda score`. Nothing is fitted to a\n"
             "measurement, except the offset of the third table and the first frame of the patella. The data and their noise are described in their folders' READMEs.\n",
             stamp + "\n"]
    if missing:
        parts.append(f"Cases without a record: {', '.join(f'`{name}`' for name in missing)}.\n")
    parts += ["## Results\n", "RMS difference from the measurement (bias; shape, the RMS without the bias). Several joints: their mean.\n",
              table(["case", "given", "frames"] + labels, found_rows(n), len(labels)),
              "Subtalar joints: coordinates about the axes of the push, the direction in which calcaneus and talus face each other\n"
              "(`--long-axis push`); the meshes are bone, and half of the cartilage is added to each. Knee in vivo: tibial rotation is nearly free\n"
              "([living-knee.md](living-knee.md) compares loads and menisci).\n",
              "In stance the measured components overlap by 0.66 mm medially and 0.40 mm laterally on average (knees/tka-dm/README.md): with four coordinates given,\n"
              "contact leaves a proximal bias of about half a millimetre with any solver.\n",
              "The millimetre of cartilage is not fitted: between 0 and 2 mm the mean shapes of the first half change by less than 0.15 degrees, so the motion does not\n"
              "determine it. The limits for subtalar joints apply to the second half of the frames.\n",
              "## Acceptance limits\n", table(["case", "measure", "at most", "found", "passed"], limit_rows(n), 2),
              "## Baselines\n", "RMS of the measurement about its mean; about its straight line over flexion, or over the frames where they were matched by frame.\n",
              table(["case"] + labels, baseline_rows(n), len(labels)),
              "## Offset from the first half\n",
              "An offset of each coordinate is fitted to the first half of the frames. In the second half: RMS; shape (RMS of the first half's mean).\n",
              table(["case"] + labels, half_rows(n), len(labels))]
    for name in ("subtalar", "subtalar-axis"):
        if name in n:
            parts += [f"## {n[name]['title']}: each foot\n", "Bias; shape.\n", table(["joint", "frames"] + labels, joint_rows(n[name]), len(labels))]
    parts += patella(n)
    parts += ["## Frames not scored\n", not_scored(n)]
    return "\n".join(parts) + "\n"
