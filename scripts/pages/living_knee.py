"""results/living-knee.md from the numbers of scripts/living_knee_numbers."""
import math

QUANTITIES = (("internal", "internal rotation", "degree"), ("varus", "varus", "degree"), ("ant", "anterior", "mm"),
              ("prox", "proximal", "mm"), ("lat", "lateral", "mm"))
NOISE_DEG = 2.0  # of the dynamic MRI, estimated in its README
OURS, SIMULATED = "vrda, unloaded", ("JAM, Lenhart 2015", "JAM, 2022")


def comparison(rows):
    """Table of RMS (largest) differences of each quantity, one row per curve."""
    lines = ["| " + " | ".join([""] + [f"{name}, {unit}" for _, name, unit in QUANTITIES]) + " |", "|---|" + "---:|" * len(QUANTITIES)]
    for name, found in rows.items():
        lines.append("| " + " | ".join([name] + [f"{found[key][0]:.1f} ({found[key][1]:.1f})" for key, _, _ in QUANTITIES]) + " |")
    return "\n".join(lines) + "\n"


def closer(trials):
    """Lists by trial the quantities that match the measurement better than each simulation."""
    lines = []
    for trial, found in trials.items():
        mine = found["differences"][OURS]
        for label in SIMULATED:
            theirs = found["differences"][label]
            better = [name for key, name, _ in QUANTITIES if mine[key][0] < theirs[key][0]]
            worse = [name for key, name, _ in QUANTITIES if mine[key][0] >= theirs[key][0]]
            lines.append(f"- {trial} against {label}: closer in {', '.join(better) or 'no coordinate'}; farther in {', '.join(worse) or 'no coordinate'}.")
    return "\n".join(lines)


def scan_line(first):
    """Difference of the pose at 0 degrees from that of the scan."""
    if first is None:
        return "Not solved at 0 degrees, so not compared with the pose of the scan (all zero)."
    angle = max(abs(first["internal"]), abs(first["varus"]))
    length = math.sqrt(sum(first[key] ** 2 for key in ("ant", "prox", "lat")))
    return (f"At 0 degrees, against the pose of the scan (all zero): internal rotation {first['internal']:.1f}, varus {first['varus']:.1f} degrees; anterior "
            f"{first['ant']:.1f}, proximal {first['prox']:.1f}, lateral {first['lat']:.1f} mm: {angle:.1f} degrees and {length:.1f} mm off.")


def optima_line(optima):
    """Flexions at which different starts led to different equilibria."""
    if not optima["places"]:
        return "All starts of the spine led to the same equilibria."
    places = ", ".join(f"{flexion:g} ({count})" for flexion, count in optima["places"])
    flexion, spread, energy = optima["worst"]
    return (f"Several equilibria at {len(optima['places'])} of {optima['flexions']} flexions (degrees, with their number): {places}. They differ most at "
            f"{flexion:g} degrees: {spread:.1f} degrees of theta apart, {energy:.3f} N mm. The one of lowest energy is used.")


def dess_table(rows):
    """Rotation of pymskt-dess, one row per kind of menisci."""
    lines = ["|  | at 15 degrees | 30 | 60 | 90 | largest change per 5 degrees | flexions solved |", "|---|" + "---:|" * 6]
    for name, found in rows.items():
        changes = ["not solved" if value is None else f"{value:.1f}" for value in found["change"].values()]
        step = "-" if found["step"] is None else f"{found['step']:.1f}"
        lines.append("| " + " | ".join([name, *changes, step, "{} of {}".format(*found["solved"])]) + " |")
    return "\n".join(lines) + "\n"


def page(n, stamp):
    """The page."""
    inside, near, width = n["band"]
    parts = ["# A knee measured in vivo\n",
             "Written by `scripts/living-knee`. The knee of `jobs/knee-jam-smith2019-ligaments.toml` (cartilage, 55 fibres, only 20 N along the tibia,\n"
             "varus free) compared with the motion of the same person's knee in dynamic MRI, and with two simulations of it. Nothing is\n"
             "fitted to the measurement. RMS difference, in brackets the largest, over the flexions of each trial that both cover, by `vrda score`\n"
             "(`--match flexion --translations mesh-origin --bridge`).\n",
             stamp + "\n", "![All curves over flexion](pictures/living-knee.svg)\n"]
    for name, trial in n["trials"].items():
        parts += [f"## Against the {name} trial ({trial['from_deg']:.0f} to {trial['to_deg']:.0f} degrees, {trial['frames']} frames)\n", comparison(trial["differences"])]
    parts += ["## Against the simulation with the same loads\n", comparison(n["same_loads"]), "## Rotation as a band\n",
              f"Under -0.5 and +0.5 N m about Delta theta moves by {width:.1f} degrees on average. {100 * inside:.0f} % of the passive trial's frames are\n"
              f"within the band, {100 * near:.0f} % within {NOISE_DEG:g} degrees (the noise of the measurement) of it.\n",
              "## The scanned pose\n", scan_line(n["scan"]["unloaded"]) + "\n", "## Comparison with the simulations\n", closer(n["trials"]) + "\n",
              "## Several equilibria\n", optima_line(n["optima"]) + "\n", "## With menisci\n",
              "Fixed to the tibia, rigid as supplied, thinned by 0.5 mm (`inset_mm`), and such that the femur may be inside them by 1 mm\n"
              "(`overlap_mm`); against the passive trial:\n", comparison(n["menisci"]),
              "One knee, a finding and not a rule: its scanned pose nearly equals the measured one, and the menisci were segmented there.\n"]
    parts += [f"{name}: {scan_line(n['scan'][name])}\n" for name in ("menisci", "menisci-thinned", "menisci-soft")]
    parts += ["The same with pymskt-dess, prepared from its meshes with the fibres of the first knee (`vrda prepare`). It has no measured motion;\n"
              "internal rotation from 0 degrees, in degrees:\n", dess_table(n["dess"]), "One knee, a finding and not a rule.\n"]
    solved = ", ".join(f"{name} {count} of {total}" for name, (count, total, _) in n["solved"].items())
    residual = ", ".join(f"{name} {worst:.2g}" for name, (_, _, worst) in n["solved"].items())
    parts.append(f"Flexions solved: {solved}. Largest balance residual, N: {residual}.")
    return "\n".join(parts) + "\n"
