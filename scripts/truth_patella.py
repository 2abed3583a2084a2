"""The patella of the measured knee for scripts/truth_cases: its jobs, and how poses of a follower are scored.

The data have no scanned pose, so the first frame takes its place: it gives the slack lengths, the angle of the tendon and
the offset of the cartilages, and is left out of the score.
"""
import csv

import numpy as np

CENTRE_MM = (53, 5, 4)
PULL_N = 30
TENDON_STRAIN = 0.02  # of the first frame, relaxed knee; the model's own slack lengths are 19 to 33 % too short there (README)
RETINACULA_STRAIN = 0.02  # likewise
TENDON_NMM_PER_RAD = 3000
JOINT = ("flexion_deg", "varus_deg", "internal_deg", "ant_mm", "prox_mm", "lat_mm")
PATELLA = ("flexion_deg", "rotation_deg", "tilt_deg", "ant_mm", "prox_mm", "lat_mm")
SCORED = ("flexion", "varus", "internal", "anterior", "proximal", "lateral")  # names of `vrda score --column` for those of PATELLA
KNEE_FOLDER, FOLDER = "knees/jam-smith2019", "patella/jam-smith2019"
CYLINDERS = {"recfem_r": "KnExt", "vasint_r": "KnExtI", "vaslat_r": "KnExt", "vasmed_r": "KnExt"}
WRAPS = """[{"name": "KnExt", "type": "WrapCylinder", "body": "femur", "xyz_body_rotation": "0 0 0",
  "translation": "0.0148 0.00687 0.00117", "radius": 0.025906, "length": 0.185, "quadrant": "all"},
 {"name": "KnExtI", "type": "WrapCylinder", "body": "femur", "xyz_body_rotation": "0 0 0",
  "translation": "0.0148 0.00687 0.00117", "radius": 0.024056, "length": 0.185, "quadrant": "all"}]
"""
HEADER = "name,bundle,from_body,from_x_mm,from_y_mm,from_z_mm,to_body,to_x_mm,to_y_mm,to_z_mm,stiffness_n_per_strain,reference_strain,tension_share,wrap"
JOB = """title = "Patella, {title}"
joint = "knee"
side = "right"

[frame]
unit = "m"

[reference]
name = "femur"
[[reference.component]]
name = "femur_cartilage"
file = "{knee}/femur_cartilage.stl"

[moving]
name = "tibia"
{tibia}
[solver]
method = "equilibrium"

[[follower]]
name = "patella"
touches = ["femur"]
centre_mm = {centre}
fibres = "{fibres}"
wraps = "{wraps}"
tension_n = {pull}
frame = {{ unit = "mm" }}
scan = {{ joint = {joint_scan}, follower = {patella_scan} }}
[[follower.direction]]
bundle = "patellar_tendon"
stiffness_nmm_per_rad = {stiffness}
[[follower.component]]
name = "patella_cartilage"
file = "{folder}/patella_cartilage.stl"
offset_mm = {offset}

{rest}"""
# The measured tibia overlaps the femur's cartilage, which stops nothing if its bone alone is in contact.
GIVEN = """[frames]
file = "{folder}/motion_passive.csv"
key = "frame"

[coordinates]
flexion = {{ column = "knee_flexion_deg" }}
varus = {{ column = "knee_varus_deg" }}
internal = {{ column = "knee_internal_deg" }}
anterior = {{ column = "knee_ant_mm" }}
proximal = {{ column = "knee_prox_mm" }}
lateral = {{ column = "knee_lat_mm" }}
"""
PREDICTED = """[moving.initial]
translation_mm = [0, -3, 0]

[push]
force_n = 20

[ligaments]
fibres = "{knee}/ligaments.csv"
wraps = "{knee}/wraps.json"

[frames]
file = "{folder}/motion_passive.csv"
key = "frame"

[coordinates]
flexion = {{ column = "knee_flexion_deg" }}
"""


def rows_of(path):
    """The table's rows, texts."""
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def corners(path, scale):
    """Corners of a binary STL file, mm."""
    data = path.read_bytes()
    triangles = np.frombuffer(data[84:], dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return np.unique(triangles["corners"].reshape(-1, 3).astype(float), axis=0) * scale


def least_distance(data, row):
    """Of the corners of the two cartilages in a measured pose, mm."""
    X = np.array([[float(row[f"T{i}{j}"]) for j in (1, 2, 3, 4)] for i in (1, 2, 3)])
    patella = corners(data / FOLDER / "patella_cartilage.stl", 1) @ X[:, :3].T + X[:, 3]
    femur = corners(data / KNEE_FOLDER / "femur_cartilage.stl", 1000)
    return min(np.linalg.norm(femur - point, axis=1).min() for point in patella)


def fibres(data):
    """Rows of the follower's table: retinacula, tendon and lines of pull."""
    point = lambda row, body: [row[f"{body}_{axis}_mm"] for axis in "xyz"]
    for row in rows_of(data / FOLDER / "retinacula.csv"):
        yield [row["name"], "retinacula", "femur", *point(row, "reference"), "patella", *point(row, "moving"), row["stiffness_n_per_strain"], RETINACULA_STRAIN, "", ""]
    for row in rows_of(data / FOLDER / "patellar_tendon.csv"):
        yield [row["name"], "patellar_tendon", "tibia", *point(row, "tibia"), "patella", *point(row, "moving"), row["stiffness_n_per_strain"], TENDON_STRAIN, "", ""]
    for row in rows_of(data / FOLDER / "quadriceps.csv"):
        yield [row["name"], "quadriceps", "femur", *point(row, "femur"), "patella", *point(row, "patella"), "", "", row["max_isometric_force_n"], CYLINDERS[row["name"]]]


def component(name, contact):
    """A component of the tibia."""
    return f'[[moving.component]]\nname = "{name}"\nfile = "{KNEE_FOLDER}/{name}.stl"\n' + ("" if contact else "contact = false\n")


def write(data, out, is_given):
    """Writes the job and its tables; returns how it is scored."""
    name = "patella-given" if is_given else "patella-predicted"
    first = rows_of(data / FOLDER / "motion_passive.csv")[0]
    table, wraps = out.resolve() / f"{name}-fibres.csv", out.resolve() / f"{name}-wraps.json"
    table.write_text("\n".join([HEADER] + [",".join(map(str, row)) for row in fibres(data)]) + "\n", encoding="utf-8")
    wraps.write_text(WRAPS, encoding="utf-8")
    tibia = component("tibia_bone", True) + ("" if is_given else component("tibia_cartilage", True))
    text = JOB.format(title="tibia as measured" if is_given else "predicted with the tibia", knee=KNEE_FOLDER, folder=FOLDER, tibia=tibia, centre=list(CENTRE_MM),
                      fibres=table, wraps=wraps, pull=PULL_N, stiffness=TENDON_NMM_PER_RAD, offset=f"{least_distance(data, first):.2f}",
                      joint_scan=[float(first[f"knee_{key}"]) for key in JOINT], patella_scan=[float(first[f"patella_{key}"]) for key in PATELLA],
                      rest=(GIVEN if is_given else PREDICTED).format(knee=KNEE_FOLDER, folder=FOLDER))
    (out / f"{name}.toml").write_text(text, encoding="utf-8")
    return [{"name": name, "motion": str(out / f"{name}.h5"), "against": str(data / FOLDER / "motion_passive.csv"),
             "options": ["--follower", "patella", *(word for name, key in zip(SCORED, PATELLA) for word in ("--column", f"{name}=patella_{key}"))],
             "rows": "2:60"}]
