"""results/knee-generic.md from the numbers of scripts/generic_knee_numbers."""
COLUMNS = {"ligaments": "equilibrium, ligaments", "contact": "equilibrium, contact only", "search": "stability search"}


def short(value, digits=3):
    """Significant digits without an exponent; empty if missing."""
    if value is None:
        return ""
    return f"{float(f'{value:.{digits}g}'):.10f}".rstrip("0").rstrip(".") if value else "0"


def row(words, cells):
    """A line of a table."""
    return f"| {words} | " + " | ".join(cells) + " |"


def page(n, stamp):
    """The page."""
    knees = [n["knees"][key] for key in COLUMNS]
    behind = n["behind"]
    heads = list(COLUMNS.values())
    marks = lambda knee: ", ".join(f"{name} {count}" for name, count in knee["marks"].items()) or "none"
    both = lambda motion: f"{motion['both_in_contact']} of {motion['poses']}" if motion else ""
    lines = ["# Generic knee\n",
             f"Written by `scripts/generic-knee`: 0 to 90 degrees of flexion and -10 to 10 of varus in steps of 1, {knees[0]['cells']} attitudes. Solved by the equilibrium with ligaments\n"
             "(`jobs/knee-generic.toml`), by the equilibrium with contact only (`jobs/knee-generic-contact.toml --set solver.method=equilibrium`), and by the\n"
             "stability search (`jobs/knee-generic-contact.toml`).\n", stamp + "\n",
             row("", heads), "|---|" + "---:|" * len(heads),
             row("stable attitudes", [str(k["stable"]) for k in knees]), row("marked as implausible", [marks(k) for k in knees]),
             row("iterations per step", [short(k["iterations"], 2) for k in knees]), row("queries per step", [short(k["queries"], 2) for k in knees]),
             row("largest penetration, re-measured, mm", [short(k["penetration_mm"]) for k in knees]), row("largest gap, re-measured, mm",
                 [short(k["gap_mm"], 2) for k in knees]),
             row("largest balance residual, of 20 N", [short(k.get("residual_n"), 2) for k in knees]), row("attitudes with theta determined",
                 [str(k["determined"]) for k in knees]),
             row("theta between neighbours in flexion, median and largest, degrees",
                 [f"{short(k['step_deg'][0], 2)}, {short(k['step_deg'][1], 2)}" for k in knees]),
             row("flexions with several equilibria", ["" if k.get("several") is None else str(k["several"]) for k in knees]),
             row("two-sided motion: both compartments in contact", [both(k["two_sided"]) for k in knees]),
             f"\nAlong Delta the equilibrium goes further than the search by {short(behind['median_mm'], 2)} mm in the median, at most by {short(behind['most_mm'], 2)} mm; at {behind['short']} of {behind['attitudes']} attitudes it "
             f"falls short,\nby {short(behind['short_mm'], 2)} mm at most (a different equilibrium). If varus is prescribed and one compartment is in contact, contact alone\n"
             "leaves theta nearly undetermined: the exact optimum can then be tens of degrees away for a hundredth of a millimetre, which `theta_determined` reports.\nLigaments constrain it.\n",
             "The scenes of `jobs/validation`, each by both methods (`--set solver.method=equilibrium`), how much further along Delta the equilibrium is, and its distance perpendicular to Delta:\n",
             "| scene | along Delta, mm | across, mm | theta, degrees | remarks |", "|---|---:|---:|---:|---|"]
    for scene in n["scenes"]:
        one, other = scene["status"]
        if one == other == "stable":
            remark = "" if scene["determined"] == 1 else "theta is not determined"
            lines.append(row(scene["title"].lower(), [f"{scene['along_mm']:.4f}", f"{scene['across_mm']:.3f}",
                f"{round(scene['theta_deg'], 1) + 0.0:.1f}", remark]))
        else:
            lines.append(row(scene["title"].lower(), ["", "", "", f"unbounded motion: `{one}`, `{other}`"]))
    lines += ["\nTested by `GenericKnee.*`: exact contact and balance at every attitude, the comparison with the search, one SHA-256 for 1 and 2 threads, three SIGKILLs, every\n"
              "instruction set and `GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA`, and starts perturbed by 2 mm and 3 degrees.\n",
              "Screw-home: the tibia rotates internally with flexion. Internal rotation along the spine, means over ten flexions and their range, degrees:\n",
              row("flexion", heads), "|---|" + "---|" * len(heads)]
    for k in range(len(knees[0]["screw_home"])):
        cells = ["" if knee["screw_home"][k][0] is None else "{:.1f} ({:.1f} to {:.1f})".format(*knee["screw_home"][k]) for knee in knees]
        lines.append(row(f"{10 * k} to {10 * k + 9}", cells))
    return "\n".join(lines) + "\n"
