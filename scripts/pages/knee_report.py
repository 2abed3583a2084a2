"""results/knee-*/README.md from the files of scripts/reports.

The knee's folder contains compare.json, compare_recontacted.json, zero_varus.csv, plots/ and remarks.md (written by hand); the records
contain audit_grid.json, audit_between.json, info.json and report.json.
"""
import collections
import csv
import json
import pathlib

from pages import tables

RESULTS = pathlib.Path(__file__).resolve().parents[2] / "results"
SHOWN_AGAINST = ("raw", "two_sided")
EVERY_DEG = 10.0  # rows of the flexion-only table
QUANTITIES = (("internal", "internal rotation, °"), ("varus", "varus, °"), ("anterior", "anterior, mm"),
              ("proximal", "proximal, mm"), ("lateral", "lateral, mm"))
FLEXION_ONLY = (("varus_deg", "varus, °"), ("internal_rotation_deg", "internal rotation, °"), ("anterior_mm", "anterior, mm"),
                ("proximal_mm", "proximal, mm"), ("lateral_mm", "lateral, mm"), ("helical_rotation_deg", "rotation, °"),
                ("instant_centre_anterior_mm", "centre anterior, mm"), ("instant_centre_proximal_mm", "centre proximal, mm"))
FILES = (("compare.json", "`vrda compare`, degrees 1 to 12"), ("compare_recontacted.json", "the same for recontacted motions"),
         ("zero_varus.csv", "the two-sided motion at each degree with axes, rolling and sliding ([columns](../../schemas/clinical.md))"),
         ("curve.csv", "the same poses in the columns of published curves, for `vrda report --against`"),
         ("knee.mot", "the same for OpenSim ([columns](../../schemas/exports.md))"))


def short(value, digits=3):
    """Rounded to significant digits; a dash if missing."""
    if value is None or value == "":
        return "–"
    return f"{float(value):.{digits}g}".replace("-", "−")


def table(headings, rows):
    """Numbers to the right of the first column."""
    return tables.table(headings, rows, len(headings) - 1)


def errors_table(compared):
    """One row per degree: residuals, prediction errors, roughness and visible differences."""
    angles = [key for key in ("theta", "varus") if key in compared["degrees"][0]["surfaces"]]
    headings = ["degree", "RMS, mm"] + [f"{key}, °" for key in angles] + ["largest, mm", "leave-one-out, mm"]
    headings += [f"{key}, °" for key in angles] + ["roughness, mm/°²", "visible"]
    rows = []
    for row in compared["degrees"]:
        translation, surfaces = row["translation"], row["surfaces"]
        mark = "**" if row["degree"] == compared["recommendation"]["degree"] else ""
        rows.append([f"{mark}{row['degree']}{mark}", short(translation["rms"])] + [short(surfaces[key]["rms"]) for key in angles]
                    + [short(translation["largest_residual"]), short(translation["leave_one_out_rms"])]
                    + [short(surfaces[key]["leave_one_out_rms"]) for key in angles]
                    + [short(translation["roughness"]), f"{100 * row['perceptible_share']:.0f} %"])
    return table(headings, rows)


def faults_table(plain, recontacted):
    """Penetration and gap at and between the grid's attitudes, plain and recontacted."""
    headings = ["degree"] + [f"{kind}, {fault} {place}" for kind in ("plain", "recontacted") for fault in ("penetration",
        "gap") for place in ("on the grid", "between")]
    rows = []
    for one, other in zip(plain["degrees"], recontacted["degrees"]):
        cells = [short(row[place][f"largest_{fault}_mm"]) for row in (one, other) for fault in ("penetration", "gap") for place in ("at_grid",
            "between")]
        rows.append([str(one["degree"])] + cells)
    return table(headings, rows)


def audits_table(at_grid, between):
    """One row per motion: audits at the grid's attitudes, and on the refined grid."""
    finer = {one["set"]: one for one in between}
    cells = lambda one: [f"{one['overlapping']} of {one['poses']}"] + [short((one[key] or {"mm": 0.0})["mm"]) for key in ("largest_penetration",
        "largest_gap")]
    rows = [[f"`{one['set']}`"] + cells(one) + cells(finer[one["set"]]) for one in at_grid]
    names = ["overlapping", "penetration, mm", "gap, mm"]
    return table(["motion", *[f"grid: {name}" for name in names], *[f"refined: {name}" for name in names]], rows)


def flexion_only_table(rows):
    """Every tenth degree of the flexion-only motion."""
    return table(["flexion, °"] + [name for _, name in FLEXION_ONLY],
                 [[short(row["flexion_deg"])] + [short(row[key]) for key, _ in FLEXION_ONLY] for row in rows])


def against_table(report):
    """RMS, largest and mean difference from each curve."""
    rows = []
    for one in report["differences"]:
        if one["curve"] in SHOWN_AGAINST:
            by = one["by_quantity"]  # records of before the rotation centre have the mesh origin's translations
            found = [by.get(key) or by[f"origin_{key}"] for key, _ in QUANTITIES]
            rows.append([f"`{one['curve']}`, `{one['against']}`"]
                        + [f"{d['rms']:.2f} ({d['largest']:.2f}; {d['mean']:+.2f})".replace("-", "−") if d else "–" for d in found])
    return table(["motion, curve"] + [heading for _, heading in QUANTITIES], rows)


PLOTS = ("stills", "summary", "surfaces", "degrees", "rotation", "translations", "comparison", "contact-paths", "axes", "branches", "forces",
    "fibres", "grid")


def two_sided_table(by_motion):
    """Poses in which both compartments are in contact, and the largest gap and overlap of each."""
    keys = [f"largest_{fault}_{side}_mm" for side in ("medial", "lateral") for fault in ("gap", "overlap")]
    rows = [[f"`{name}`", f"{one['both_in_contact']} of {one['poses']}"] + [short(one[key]) for key in keys] for name, one in by_motion.items()]
    return table(["motion", "both in contact", "medial gap, mm", "medial overlap", "lateral gap", "lateral overlap"], rows)


def collect(folder, records):
    """Only what the page shows."""
    load = lambda path: json.loads(path.read_text(encoding="utf-8"))
    report, info = load(records / "report.json"), load(records / "info.json")
    model = report["models"][0]
    with open(folder / "zero_varus.csv", encoding="utf-8") as file:
        rows = [{key: row[key] for key in ("flexion_deg", *(name for name,
            _ in FLEXION_ONLY))} for row in csv.DictReader(file) if float(row["flexion_deg"]) % EVERY_DEG == 0.0]
    marks = collections.Counter(cell["plausibility"] for cell in info["doubtful"])
    return {"folder": folder.name, "title": model["title"], "stable": model["numbers"]["stable"], "cells": model["numbers"]["cells"],
        "warnings": model["warnings"],
            "marks": dict(sorted(marks.items())), "two_sided": info["two_sided"], "plain": load(folder / "compare.json"),
            "recontacted": load(folder / "compare_recontacted.json"),
            "audit_grid": load(records / "audit_grid.json"), "audit_between": load(records / "audit_between.json"), "rows": rows,
            "against": bool(report["against"]), "differences": [one for one in report["differences"] if one["curve"] in SHOWN_AGAINST],
            "plots": [name for name in PLOTS if (folder / "plots" / f"{name}.png").exists()]}


def page(n, stamp):
    """The page."""
    plain, recontacted = n["plain"], n["recontacted"]
    reason = plain["recommendation"]["reason"]
    if plain["recommendation"]["degree"] is None:
        reason = f"no degree meets the criteria ({plain['recommendation']['status']}): {reason}"
    marks = ", ".join(f"{name} {count}" for name, count in n["marks"].items()) or "none"
    parts = [f"# {n['title']}\n",
             f"Written by `scripts/reports` of `jobs/{n['folder']}.toml`: {n['stable']} of {n['cells']} attitudes solved.\n"
             "The commands are in that script, which also writes the report page `report/index.html`.\n", stamp + "\n",
             "\n".join(f"- [{name}]({name}): {what}" for name, what in FILES) + "\n",
             f"Stable attitudes marked as implausible (`/plausibility`): {marks}.\n",
             "Warnings of the report:\n\n" + ("\n".join(f"- {line}" for line in n["warnings"]) or "- none") + "\n",
             (RESULTS / n["folder"] / "remarks.md").read_text(encoding="utf-8").strip() + "\n",
             "## Degrees of smoothing\n", f"{reason[0].upper()}{reason[1:]}.\n", errors_table(plain),
             "Visible: share of attitudes that move by more than 0.145 mm or 0.27 degrees. Largest penetration and gap in mm along Delta, at the attitudes of the grid and\n"
             "halfway between them, of the polynomials and of the motions after `--recontact`:\n", faults_table(plain, recontacted),
             "## Audits\n", "`vrda audit --set all`, at the grid's attitudes, and with each cell divided into 4 x 4 (4 if varus is free):\n",
             audits_table(n["audit_grid"], n["audit_between"]),
             "Both compartments in contact (within 0.145 mm), of the poses of each motion:\n",
             two_sided_table(n["two_sided"]),
             "## Flexion alone\n",
             "The two-sided motion, which is the default of player and exports; rotation and instant centre between this flexion and the next row of `zero_varus.csv`:\n",
             flexion_only_table(n["rows"])]
    if n["against"]:
        parts += ["## Against measured and simulated curves\n",
                  "RMS difference (largest; mean of VRDA's curve minus the other). Nothing is fitted. The first is a passive cycle of the same person's knee in dynamic\n"
                  "MRI (noise about 1 to 2 degrees and 1 mm), the others are simulations of it.\n", against_table(n)]
    parts += ["## Pictures\n", "\n\n".join(f"![{name}](plots/{name}.png)" for name in n["plots"])]
    return "\n".join(parts) + "\n"
