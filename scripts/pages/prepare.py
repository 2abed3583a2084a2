"""results/prepare.md from the numbers of scripts/prepare_trials."""
import math
import statistics

from pages.tables import table

FLEXIONS = range(0, 91, 5)
SHOWN = range(0, 91, 15)
INTERNAL, VARUS = 0, 1  # of the coordinates of a curve; the other three are translations
SCANS = (("stump 60", "stumps of 60 mm"), ("stump 35", "of 35 mm"), ("flexed 30", "flexed by 30"), ("flexed 60", "by 60"), ("flexed 90", "by 90"),
         ("noise", "noise of 0.5 mm"))


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values)) if values else math.nan


def off(rows, others, quantity):
    """RMS difference of two curves over the flexions that both have."""
    return rms([rows[f][quantity] - others[f][quantity] for f in rows if f in others])


def extent(rows, quantity):
    values = [row[quantity] for row in rows.values()]
    return max(values) - min(values)


def turned_rows(n):
    return [[name, f"{t['right']} of {t['tried']}", f"{t['margin']:.2f}", f"{t['degrees']:.3f}", f"{t['mm']:.3f}",
             "NO" if not n["scans"][name]["mirrored"].get("is_right") else
             "yes; {degrees:.3f}, {mm:.3f}".format(**n["scans"][name]["mirrored"])] for name, t in n["turned"].items()]


def scan_cell(found):
    return f"refused: {found['refused']}" if "refused" in found else f"{found['femur_deg']:.1f}, {found['tibia_deg']:.1f}, {found['flexion_deg']:.1f}"


def scan_rows(n):
    return [[name, *(scan_cell(scans[key]) for key, _ in SCANS), f"{n['scanned_flexion_deg'][name]:.1f}"] for name, scans in n["scans"].items()]


LARGEST_DEG = {"stump 60": 2.5, "stump 35": 5.0, "flexed 30": 0.5, "flexed 60": 0.5, "noise": 2.5}


def missed_scans(n):
    """The scans whose frames are beyond the target."""
    names = dict(SCANS)
    missed = [f"{name}, {names[key]}: {max(found['femur_deg'], found['tibia_deg']):.1f} degrees"
              for name, scans in n["scans"].items() for key, most in LARGEST_DEG.items()
              if "refused" not in (found := scans[key]) and max(found["femur_deg"], found["tibia_deg"]) > most]
    return f"Beyond the target: {'; '.join(missed) or 'none'}.\n"


def loads(found):
    """Largest strain, largest tension of a bundle, bundles that prepare names."""
    strain = max(found["bundles"], key=lambda b: b["largest_strain"])
    tension = max(found["bundles"], key=lambda b: b["largest_tension_n"])
    return [f"{strain['largest_strain']:.2f} ({strain['name']})", f"{tension['largest_tension_n']:.0f} ({tension['name']})", ", ".join(found["named"]) or "none"]


def motion_cells(rows):
    """Solved flexions, range of internal rotation, largest range of a translation."""
    return [f"{len(rows)} of {len(FLEXIONS)}", f"{extent(rows, INTERNAL):.1f}", f"{max(extent(rows, q) for q in range(2, 5)):.1f}"]


def solved_rows(n):
    for name, found in n["solved"].items():
        if "refused" in found:
            yield [name, f"refused: {found['refused']}"] + [""] * 8
            continue
        solved, turn, travel = motion_cells(found["motion"])
        yield [name, solved, f"{off(found['motion'], n['template'], INTERNAL):.1f}", turn, travel, *loads(found),
               ", ".join(f"{r:.2f}" for r in found["residuals_mm"]), ", ".join(f"{s:.0f}" for s in found["seconds"])]


def generic_rows(n):
    for name, found in n["generic"].items():
        if "refused" in found:
            yield [name, f"refused: {found['refused']}"] + [""] * 9
            continue
        yield [name, "yes" if found["is_right"] else "NO", f"{found['margin']:.2f}", *("{:.1f}, {:.1f}".format(*found[bone]) for bone in ("femur", "tibia")),
               ", ".join(f"{r:.2f}" for r in found["residuals_mm"]), *motion_cells(found["motion"]), *loads(found)]


def curve_rows(n):
    curves = {"jam-smith2019, its own job": n["template"], **{name: found["motion"] for name, found in n["solved"].items() if "motion" in found}}
    return [[name, *(f"{rows[str(f)][INTERNAL]:.1f}" if str(f) in rows else "-" for f in SHOWN)] for name, rows in curves.items()]


def deformed_rows(n):
    for template, (_, *seeds) in n["deformed"].items():
        solved = [s for s in seeds if "internal_deg" in s]
        spread = [f"{statistics.median(s[key] for s in solved):.2f} ({max(s[key] for s in solved):.2f})"
                  for key in ("internal_deg", "varus_deg", "anterior_mm")] if solved else ["", "", ""]
        attached = [s["attachments_mm"] for s in seeds if "attachments_mm" in s]
        yield [template, f"{len(solved)} of {len(seeds)}", f"{statistics.median(attached):.2f} ({max(attached):.2f})", *spread]


def itself_rows(n):
    own = n["solved"]["jam-smith2019"].get("motion", {})
    yield ["jam-smith2019", "`vrda prepare`", *(f"{off(own, n['template'], q):.2f}" for q in (INTERNAL, VARUS, 2))]
    for template, (zero, *_) in n["deformed"].items():
        yield [template, "seed 0", *(f"{zero[key]:.2f}" if key in zero else "-" for key in ("internal_deg", "varus_deg", "anterior_mm"))]


def sides_rows(n):
    return [[bone, *(f"{angle:.2f}" for angle in found["degrees"]), f"{found['mm']:.2f}"] for bone, found in n["both_sides"].items()]


def page(n, stamp):
    """The page."""
    pictures = [f"{name}:\n\n![Frames, side and fibres of {name}](prepare/{name}.jpg)\n\n![{name} at 0, 30, 60 and 90 degrees](prepare/{name}-motion.jpg)\n"
                for name, found in n["solved"].items() if "motion" in found]
    return "\n".join([
        "# `vrda prepare` on real knees\n",
        "Written by `scripts/prepare_trials`. The template is jam-smith2019 (femoral cartilage, tibia with cartilage, 55 fibres) or the generic knee; the four knees",
        "are those of [jobs/README.md](../jobs/README.md). The Visible Human knees have femoral cartilage only, so the scales of their femur are regularised to the tibia's.\n",
        stamp + "\n",
        "## Unit, side and frames\n",
        f"{n['orientations']} random rotations and positions of each knee, each in mm, cm and m, by the template jam-smith2019. The frame is compared with that of the",
        "unmoved scan; target: within 0.3 degrees and 0.3 mm. Unit and side of each must be correct. The fit does not use the fibula, so these frames are the same with one.\n",
        table(("knee", "unit and side right", "least margin of the side", "frame, degrees", "frame, mm", "mirrored mesh: other side; frame, degrees, mm"), turned_rows(n)),
        "The left Visible Human knee mirrored onto the right one of the same person: difference of the frames after a rigid fit of the bones to each other;",
        "target: within 2 degrees about each axis and 2.5 mm.\n",
        table(("bone", "about X (anterior), degrees", "about Y (proximal)", "about Z (right)", "mm"), sides_rows(n)),
        "## Other scans of the same knees\n",
        "Difference of the femur's and of the tibia's frame from that of the unchanged scan in degrees, and the flexion found. Stumps are cut at a distance",
        "from the joint line (target: 60 mm within 2.5 degrees, 35 mm within 5 or refused); flexed scans are turned about the flexion axis (30 and 60 degrees: frame within",
        "0.5, flexion within 2; 90: right or refused); noise moves each vertex (within 2.5 degrees).\n",
        table(("knee", *(head for _, head in SCANS), "flexion of the unchanged scan"), scan_rows(n)),
        missed_scans(n),
        "## The prepared jobs\n",
        "Flexion 0 to 90 by 5 degrees, varus free, 20 N. Target: all solved, internal rotation within 8 degrees RMS of the template's and its range at most 25,",
        "excursion at most 15 mm, strain at most 0.15 and tension at most 1,000 N per bundle, or a warning names the bundle. Strains and tensions are those of `prepare.json`.\n",
        table(("knee", "flexions solved", "internal rotation against the template, RMS degrees", "its range, degrees", "largest excursion, mm", "largest strain",
               "largest tension of a bundle, N", "bundles named", "residuals of femur and tibia, mm", "seconds: prepare, run, pictures"), solved_rows(n)),
        "![Internal rotation over flexion](prepare/rotation.svg)\n",
        table(("internal rotation at", *map(str, SHOWN)), curve_rows(n)),
        *pictures,
        "## With the generic template\n",
        "Without `--template`: the generated shape `knee-template`, whose solids were fitted to points of these four knees, so these knees are not independent of it.",
        "Frames are compared with those by jam-smith2019 (degrees, mm); target: within 5 degrees and 4 mm.\n",
        table(("knee", "unit and side right", "margin of the side", "femur", "tibia", "residuals, mm", "flexions solved", "range of internal rotation, degrees",
               "largest excursion, mm", "largest strain", "largest tension of a bundle, N", "bundles named"), generic_rows(n)),
        "## Knees whose ligaments are known\n",
        f"A template deformed by up to 12 % along each axis and by smooth waves of 1 mm, {n['seeds']} seeds (`tests/prepare/deformed_knee_test.cpp`), prepared with the template itself.",
        "The motion is compared with that of the same bones with the deformed attachments; each motion in its own frames, RMS over 0 to 90 degrees. Median (largest); target:",
        "all solved, attachments within 2 mm on average, internal rotation median 3 and largest 6 degrees, anterior 1.5 mm.\n",
        table(("template", "solved with all flexions", "attachments off by, mean mm", "internal rotation, degrees", "varus, degrees", "anterior, mm"), deformed_rows(n)),
        "The template prepared with itself; target: within 2 degrees of internal rotation, 0.5 of varus, 0.5 mm:\n",
        table(("template", "by", "internal rotation, RMS degrees", "varus, RMS degrees", "anterior, RMS mm"), itself_rows(n)),
        "## What the template does not have\n",
        "Transfer is judged against the template. The internal rotation of jam-smith2019 under 20 N peaks at 40 degrees of flexion and then falls, and its",
        "rollback is medial, unlike the curve of Walker et al. (1988), which increases to 90 degrees. A prepared knee inherits that. The template has no femoral",
        "bone, so on its subjects attachments on the femur go to the nearest bone surface, and the femur's scale comes from cartilage."]) + "\n"
