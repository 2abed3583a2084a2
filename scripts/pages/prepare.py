"""results/prepare.md from the numbers of scripts/prepare_trials."""
from pages.tables import table

HEADS = {
    "found": ("knee", "unit and side right", "least margin of the side", "frame, degrees", "frame, mm",
              "mirrored mesh: side, largest difference of scanned angles", "seconds"),
    "robust": ("knee", "stumps of 60 mm", "of 35 mm", "flexed by 30", "by 60", "by 90", "noise of 0.5 mm", "flexion of the unchanged scan"),
    "solved": ("knee", "flexions solved", "internal rotation against the template, RMS degrees", "its range, degrees", "largest excursion, mm",
               "largest strain", "largest tension of a bundle, N", "residuals of femur and tibia, mm", "seconds of prepare"),
    "generic": ("knee", "unit and side right", "margin of the side", "femur: degrees, mm", "tibia: degrees, mm", "residuals, mm", "flexions solved",
                "range of internal rotation, degrees", "largest strain"),
    "curves": ("internal rotation at", *(str(flexion) for flexion in range(0, 91, 15))),
}


def page(recorded, stamp):
    """The page."""
    tables = {name: table(head, [row for row in recorded.get(name, []) if row]) for name, head in HEADS.items()}
    generic = [] if "generic" not in recorded else [
        "## With the generic template\n",
        "Without `--template`: the generated shape `knee-template`, whose solids were fitted to points of these four knees, so these are not other people.",
        "Frames are compared with those by jam-smith2019.\n",
        tables["generic"]]
    return "\n".join([
        "# `vrda prepare` on real knees\n",
        "Written by `scripts/prepare_trials`. The template is jam-smith2019 (femoral cartilage, tibia with cartilage, 55 fibres); the four knees are those of",
        "[jobs/README.md](../jobs/README.md). The Visible Human knees have femoral cartilage only, so their femur takes the tibia's size.\n",
        stamp + "\n",
        "## Unit, side and frames\n",
        f"{recorded['orientations']} random rotations and positions of each knee, in turn in mm, cm and m. The frame is compared with that of the unmoved scan.\n",
        tables["found"],
        "## Other scans of the same knees\n",
        "Difference of the femur's and of the tibia's frame from that of the unchanged scan in degrees, and the flexion found. Stumps are cut at a distance",
        "from the joint line; flexed scans are turned about the flexion axis; noise moves each vertex.\n",
        tables["robust"],
        "## The prepared jobs\n",
        "Flexion 0 to 90 by 5 degrees, varus free, 20 N. Strains and tensions are those of `prepare.json`.\n",
        tables["solved"],
        tables["curves"],
        *generic,
        "## What the template does not have\n",
        "Transfer is judged against the template. The internal rotation of jam-smith2019 under 20 N peaks at 40 degrees of flexion and then falls, and its",
        "rollback is medial, unlike the curve of Walker et al. (1988), which increases to 90 degrees. A prepared knee inherits that. The template has no femoral",
        "bone, so on its subjects attachments on the femur go to the nearest bone surface, and the femur's scale comes from cartilage."]) + "\n"
