"""results/uncertainty.md from the numbers of scripts/uncertainty_numbers."""
import json
import re

from pages.tables import table

NAMES = {"varus": "varus", "internal": "internal rotation", "anterior": "anterior", "proximal": "proximal", "lateral": "lateral"}
UNITS = {"varus": "degree", "internal": "degree", "anterior": "mm", "proximal": "mm", "lateral": "mm"}


def collect(*files):
    """One object of the parts."""
    numbers = {}
    for file in files:
        numbers.update(json.loads(file.read_text(encoding="utf-8")))
    return numbers


def percent(share):
    return f"{100 * share:.0f}"


def coverage(n):
    """Synthetic knees."""
    rows = [[NAMES[key], f"{100 * n['shares'][key]:.1f}", f"{percent(n['least_flexion'][key])} to {percent(n['most_flexion'][key])}",
             f"{n['widths'][key]:.2f} {UNITS[key]}"] for key in NAMES]
    unsolved = f"{n['failed']} of the poses are unsolved" if n["failed"] else "All poses are solved"
    return [f"The generic knee, {n['flexions']} flexions from 0 to 90 degrees, varus free, with {n['samples']} samples. The truth is {n['knees']} knees whose stiffness (lognormal, 0.3, one draw per bundle),\n"
            "reference strain (normal, 0.02, correlation 0.5 within a bundle), moment about Delta (normal, 300 N mm) and push (10 to 40 N) are drawn by numpy from the same distributions. Each is solved\n"
            f"by a separate job, with all restarts of the spine. {unsolved}. Target: 85 to 95 %.\n",
            table(["coordinate", "truth within the band, %", "by flexion, %", "mean width of the band"], rows, 3)]


def samples(n):
    """Time and bytes."""
    hashes = sorted(set(n["hashes"].values()))
    rows = [[re.sub(r"^1 (\w+)s$", r"1 \1", name), f"`{digest[:16]}`"] for name, digest in n["hashes"].items()]
    same = "One hash" if len(hashes) == 1 else f"**{len(hashes)} hashes**"
    return [f"500 samples of `jobs/knee-jam-smith2019-ligaments.toml` (55 fibres, flexion 0 to 90 by 5, varus free) with {n['draws']} draws: stiffness of each bundle, reference strain of each fibre.\n"
            f"{n['processor']:.0f} s of processor time, {n['seconds']:.0f} s with two threads on two cores (target: less than 300).\n"
            f"{same} of the motion model of {n['hashed']} such samples:\n", table(["run", "SHA-256"], rows),
            f"Stable poses: {sum(n['solved'])} of {500 * len(n['solved'])}. What the spread comes from (first-order Sobol index, its 90 % interval, rank correlation; over all flexions):\n",
            shares(n["shares"])]


def shares(found):
    rows = [[NAMES[key], "; ".join(f"{draw} {percent(index)} % ({percent(low)} to {percent(high)}, {rank:+.2f})" for draw, index, low, high, rank in found[key])] for key in NAMES]
    return table(["coordinate", "largest shares"], rows)


def living(n):
    """MRI frames."""
    parts = []
    for name, found in n.items():
        rows = [[trial, *(f"{percent(shares_of[key][0])} ({shares_of[key][1]:.1f})" for key in NAMES)] for trial, shares_of in found["trials"].items()]
        parts += [f"### {name[0].upper()}{name[1:]}\n", table(["trial", *(f"{NAMES[key]}, % (width, {UNITS[key]})" for key in NAMES)], rows, len(NAMES)),
                  f"{found['solved']} of {found['of']} sampled poses are stable. Rotation: "
                  + "; ".join(f"{draw} {percent(index)} %" for draw, index, *_ in found["shares"]["internal"]) + ".\n"]
    return parts


def page(n, stamp):
    """The page."""
    return "\n".join(["# Bands of uncertain jobs\n", "Written by `scripts/uncertainty`. [schemas/uncertainty.md](../schemas/uncertainty.md) defines the draws, bands and indices.\n", stamp + "\n",
                      "## Coverage of synthetic knees\n", *coverage(n["coverage"]),
                      "## 500 samples of a real knee\n", *samples(n["samples"]),
                      "## A knee measured in vivo\n", *living_text(), *living(n["living"])])


def living_text():
    """The distributions and their sources."""
    return ["300 samples of `jobs/knee-jam-smith2019-ligaments.toml`, flexion 0 to 54 by 3, varus free, against the frames of three trials in the scanner (data: Lenhart et al. 2015, Ann Biomed Eng 43:2675).\n"
            "Stiffness: normal, standard deviation 30 % of the fibre's, one draw per bundle; reference strain: normal, 0.02, one draw per bundle: the Monte Carlo simulation of Smith et al. 2016\n"
            "(J Knee Surg 29:99). Attachments: normal, 1.5 mm in each direction along the surface, chosen by this project; Baldwin et al. 2009 (Comput Methods Biomech Biomed Eng 12:651) vary them too.\n"
            "Cells: share of frames within the 5 to 95 % band, and in brackets its mean width. Target for rotation: 80 % with at most 12 degrees.\n"
            "The bands do not contain the noise of the frames, 1 to 2 degrees and 1 mm by their scatter.\n",
            "![Measured frames over the bands](pictures/uncertainty.svg)\n"]
