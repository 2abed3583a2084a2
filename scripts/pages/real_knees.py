"""results/real-knees.md from the JSON of `vrda info` of the real knees' models."""
import collections
import json

MEANING = {
    "stable": "in equilibrium",
    "no_contact": "no contact along Delta: the objects separated or never met",
    "no_clearance": "no collision-free pose within the retreat distance: the objects interpenetrate",
    "iteration_limit": "no equilibrium within max_steps",
}
PARTS = ("title", "triangles", "status", "unsolved", "doubtful", "remeasured", "iterations", "two_sided")


def collect(*files):
    """The page's part of each `vrda info --json`."""
    infos = [json.loads(file.read_text(encoding="utf-8")) for file in files]
    return [{part: info[part] for part in PARTS} for info in infos]


def where(info, status):
    """Attitudes with a status: varus values at each flexion."""
    rows = {}
    for cell in info["unsolved"]:
        if cell["status"] == status:
            rows.setdefault(cell["flexion_deg"], []).append(f"{cell['varus_deg']:g}")
    return "; ".join(f"flexion {flexion:g}: varus {', '.join(varus)}" for flexion, varus in rows.items())


def row(info):
    """Table row of a knee."""
    measured = info["remeasured"]
    counts = [str(info["status"].get(status, 0)) for status in MEANING]
    gap = measured["largest_gap_mm"]
    marks = collections.Counter(cell["plausibility"] for cell in info["doubtful"])
    marked = ", ".join(f"{name} {count}" for name, count in sorted(marks.items())) or "none"
    motion = info["two_sided"].get("two_sided")
    both = f"{motion['both_in_contact']} of {motion['poses']}" if motion else "none"
    cells = [info["title"], f"{info['triangles']['reference']:,} x {info['triangles']['moving']:,}", *counts,
             marked, f"{measured['largest_penetration_mm']:g}", "none" if gap is None else f"{gap:.3g}",
             f"{info['iterations']['mean']:.1f}", both]
    return "| " + " | ".join(cells) + " |"


def page(infos, stamp):
    """The page."""
    n = sum(infos[0]["status"].values())
    names = " | ".join(MEANING)
    lines = ["# Real knees\n",
             f"Written by `scripts/real-knees`: the four jobs of `jobs/`, stability search, {n} attitudes each, no ligaments.",
             "Penetration and gap (mm) are re-measured at every stable attitude, from the stored meshes and poses.\n",
             stamp + "\n",
             f"| knee | triangles | {names} | marked as implausible | penetration | gap | iterations per step | two-sided motion: both in contact |",
             "|---|---|" + "---|" * (len(MEANING) + 5),
             *map(row, infos),
             "\nMeaning of the status values, and the attitudes concerned:\n"]
    for status, meaning in MEANING.items():
        places = [f"{info['title']} ({where(info, status)})" for info in infos if status != "stable" and where(info, status)]
        lines.append(f"- `{status}`: {meaning}." + (" " + "; ".join(places) + "." if places else ""))
    lines.append("\nTwo-sided motion: poses in which both compartments are within 0.145 mm, of those at every quarter of a degree of flexion.\n"
                 "For the plausibility codes see `/plausibility` of [motion-model.md](../schemas/motion-model.md). With contact alone a tibia can rotate freely and, without menisci, slide off the femur; in\n"
                 "vivo, ligaments prevent this.")
    return "\n".join(lines) + "\n"
