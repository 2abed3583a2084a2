"""results/believable.md from the numbers of scripts/believable."""
import json

from pages.tables import table

LIMITS = {"net": "8 to 20", "drop": "at most 3", "step": "at most 3", "early": "at least 0.55", "medial": "at most 6", "lateral": "8 to 16", "optima": "0",
          "noise_rms": "at most 1.5", "noise_most": "at most 3", "half_rms": "at most 1", "noise_solved": "19", "solved": "19", "both": "at least 17", "times": "at most 3", "band_times": "at most 3"}
ROWS = (("net", "net internal rotation from 0 to 90, degrees", ".1f"), ("drop", "drop after the peak, degrees", ".1f"), ("step", "largest change per 5 degrees, degrees", ".1f"),
        ("early", "share of the peak reached by 30 degrees", ".2f"), ("medial", "medial facet centre back at 90 degrees, mm", ".1f"),
        ("lateral", "lateral facet centre back at 90 degrees, mm", ".1f"), ("optima", "flexions with perceptibly distinct equilibria", "d"),
        ("noise_rms", "surface noise of 1 mm, whole pipeline: RMS of rotation, degrees", ".2f"), ("noise_most", "the same, largest, degrees", ".2f"),
        ("noise_solved", "the same, solved flexions of 19", "d"), ("half_rms", "half of the triangles, frames and fibres held: RMS of the change of rotation, degrees", ".2f"), ("solved", "solved flexions of 19", "d"),
        ("both", "flexions with both compartments in contact, in the motion that is shown", "d"), ("times", "processor time over that of exact contact without the prior", ".2f"),
        ("band_times", "processor time with the band over that without it", ".2f"))
LIVING_LIMITS = {"passive": 6.0, "inertia": 5.8, "elastic": 5.4}


def collect(file):
    return json.loads(file.read_text(encoding="utf-8"))


def shown(value, spec):
    return "-" if value is None else format(int(value) if spec == "d" else value, spec)


def page(n, stamp):
    knees = n["knees"]
    rows = [[name, LIMITS[key], *(shown(knee[key], spec) for knee in knees.values())] for key, name, spec in ROWS]
    def part(of):
        first = next(iter(knees.values()))[of]
        return table([of_name[of], *knees], [[name, *(shown(knee[of][key], spec) for knee in knees.values())] for key, name, spec in ROWS if key in first], len(knees))

    of_name = {"exact": "the prior, exact contact", "alone": "compliant contact without the prior", "today": "exact contact without the prior"}
    share = ", ".join(f"{name} {100 * knee['share']:.0f} %" for name, knee in knees.items())
    text = ["# Motion of bare bones\n", stamp,
            "Knees prepared from their meshes alone by `vrda prepare` with its defaults, flexion 0 to 90 by 5 degrees, varus free, compliant contact. The prior pulls the rotation and the\n"
            "position between the condyles to the mean passive motion of cadaver knees (Walker 1988; [prior.md](../schemas/prior.md)): without it bones and transferred fibres do not turn as knees do.\n"
            f"Share of the rotation that the prior decides: {share}.\n",
            table(["with the prior", "limit", *knees], rows, len(knees)),
            "\nThe same jobs with exact contact, which touches the highest points of a scanned surface, and the bones and fibres alone:\n",
            *(part(of) for of in of_name)]
    if "living" in n:
        trials = n["living"]["trials"]
        inside = sum(t["inside"] * t["frames"] for t in trials.values()) / sum(t["frames"] for t in trials.values())
        text += ["\n## The knee measured in vivo\n\nThe jam-smith2019 knee with its own 55 fibres, the prior and its band, against dynamic MRI of the same person (Lenhart 2015). Nothing is fitted to it;\n"
                 "no rotation: the difference from a motion without any.\n",
                 table(["trial", "limit, degrees", "RMS of rotation with the prior", "bones alone", "no rotation", "measured frames in the 90 % band, %"],
                       [[name, LIVING_LIMITS[name], *(f"{t[key]:.1f}" for key in ("prior", "alone", "null")), f"{100 * t['inside']:.0f}"] for name, t in trials.items()], 4),
                 f"\nOf the frames of all trials {100 * inside:.0f} % are in the band (limit 85 %).\n"]
    return "\n".join(text)
