"""results/laxity.md from laxity.json of `vrda laxity`."""
import json

from pages.tables import table

PAIRS = (("anterior", "posterior"), ("internal", "external"), ("varus", "valgus"))
SMALLEST = 0.05  # share below which a bundle is not listed
COORDINATES = {"anterior": "anterior_mm", "posterior": "anterior_mm", "internal": "internal_deg", "external": "internal_deg",
               "varus": "varus_deg", "valgus": "varus_deg"}
SIGNS = {"anterior": 1, "posterior": -1, "internal": 1, "external": -1, "varus": 1, "valgus": -1}
CUTS = {"ACL": ("ACLam", "ACLpl"), "LCL": ("LCL",)}


def collect(path):
    """The curves without the job's text and the steps of the loads."""
    found = json.loads(path.read_text(encoding="utf-8"))
    curves = []
    for curve in found["curves"]:
        sign, coordinate = SIGNS[curve["test"]], COORDINATES[curve["test"]]
        curves.append({**{key: curve[key] for key in ("state", "flexion_deg", "test", "unit", "laxity", "bundles", "contact")},
                       "load": curve["poses"][-1]["load"], "status": curve["poses"][-1]["status"], "replaced": curve.get("replaced"),
                       "position": sign * curve["poses"][-1]["coordinates"][coordinate]})
    return {"flexion_deg": found["flexion_deg"], "states": found["states"], "curves": curves}


def share_of(curve, names):
    return sum(bundle["share"] for bundle in curve["bundles"] if bundle["name"] in names)


def number(value, form=".2f"):
    return "-" if value is None else format(value, form)


def laxities(n, curves, pair):
    """Laxity of each state."""
    rows = []
    for flexion in n["flexion_deg"]:
        for state in n["states"]:
            values = [curves[state, flexion, test]["laxity"] for test in pair]
            both = None if None in values else sum(values)
            rows.append([f"{flexion:g}", state if state == "intact" else f"without {state}", *map(number, (*values, both))])
    return table(["flexion, degrees", "state", *pair, "both"], rows, 3)


def shares(n, curves, pair):
    """Largest shares with all fibres."""
    rows = []
    for flexion in n["flexion_deg"]:
        cells = []
        for test in pair:
            curve = curves["intact", flexion, test]
            parts = sorted([*curve["bundles"], curve["contact"]], key=lambda part: -abs(part["share"] or 0))
            cells.append(", ".join(f"{part['name']} {100 * part['share']:.0f} %" for part in parts if abs(part["share"] or 0) >= SMALLEST))
        rows.append([f"{flexion:g}", *cells])
    return table(["flexion, degrees", *pair], rows)


def cuts(n, curves):
    """Share of the cut fibres and the change by the cut."""
    rows = []
    for state, test in (("ACL", "anterior"), ("LCL", "varus")):
        for flexion in n["flexion_deg"]:
            whole, cut = curves["intact", flexion, test], curves[state, flexion, test]
            replaced = cut["replaced"] or {"distance_mm": None, "angle_deg": None}
            change = None if cut["laxity"] is None else cut["position"] - whole["position"]
            rows.append([state, test, f"{flexion:g}", f"{100 * share_of(whole, CUTS[state]):.0f} %", number(whole["laxity"]), number(cut["laxity"]),
                         number(change, "+.2f"), number(replaced["distance_mm"], ".4f"), number(replaced["angle_deg"], ".4f")])
    return table(["cut", "test", "flexion, degrees", "share of the load", "laxity, intact", "laxity, cut", "change of position under load by the cut",
                  "replaced by its forces: mm", "degrees"], rows, 6)


def page(n, stamp):
    """The page."""
    curves = {(curve["state"], curve["flexion_deg"], curve["test"]): curve for curve in n["curves"]}
    n_solved = sum(curve["status"] == "stable" for curve in n["curves"])
    parts = ["# Laxity\n",
             "Written by `scripts/laxity`: `vrda laxity` on the knee of `jobs/knee-jam-smith2019-ligaments.toml` (cartilage, 55 fibres, 20 N along the tibia).\n"
             "Flexion is held, the other coordinates are free; 100 N forwards and backwards, 5 N m internally and externally, 10 N m of varus and valgus, in ten steps\n"
             "each (`schemas/laxity.md`). Nothing is fitted. mm and degrees.\n",
             stamp + "\n", f"{n_solved} of {len(n['curves'])} tests were solved up to the full load.\n",
             "![Displacement over load, laxity over flexion](pictures/laxity.svg)\n",
             "## Effect of cuts\n",
             "The share of the load that the fibres carry in the intact knee, and the laxity without them. The change of position under load includes the change of the\n"
             "unloaded pose by the cut, which the laxities, measured from the unloaded pose of each state, do not. Last: the cut knee under the load and\n"
             "constant tensions equal to the forces of the cut fibres in the intact knee; its distance from the pose of the intact knee is zero if they carried that share.\n",
             cuts(n, curves)]
    for pair in PAIRS:
        unit = curves["intact", n["flexion_deg"][0], pair[0]]["unit"]
        parts += [f"## {pair[0].capitalize()}-{pair[1]}, {unit}\n", laxities(n, curves, pair),
                  "Shares of the load with all fibres, at least 5 %:\n", shares(n, curves, pair)]
    return "\n".join(parts)
