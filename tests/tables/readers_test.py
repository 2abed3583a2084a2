"""Reads the files of vrda export with other programs: VTK (ParaView's reader), pandas, and xarray in the
notebook. The expected numbers come from the motion model by h5py.

usage: readers_test.py VRDA
exit: 0 all is well, 1 a finding (printed)
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import h5py
import numpy
import pandas
import PIL.Image
import vtk
import xarray
from vtk.util.numpy_support import vtk_to_numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
FLEXIONS = [0.0, 30.0, 60.0, 90.0]
SINGLE_MM = 2e-5  # single precision of coordinates within 200 mm
TOUCH_MM = 1e-3  # contact points are on the reference; the equilibrium's gap is below a micrometre


def check(condition, why):
    if not condition:
        print("wrong: " + why)
        sys.exit(1)


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    check(done.returncode == 0, f"{command} ended with {done.returncode}: {done.stderr}")
    return done


def turned(axis, angle_deg):
    c, s = numpy.cos(numpy.radians(angle_deg)), numpy.sin(numpy.radians(angle_deg))
    if axis == "x":
        return numpy.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    if axis == "y":
        return numpy.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return numpy.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def vertices(model, body):
    group = model[f"bodies/{body}"]
    visual = [group["visual/vertices"][:]] if "visual" in group else []
    return numpy.concatenate([group["vertices"][:]] + visual)


def read_vtp(path):
    reader = vtk.vtkXMLPolyDataReader()
    check(reader.CanReadFile(str(path)) == 1, f"VTK cannot read {path}")
    reader.SetFileName(str(path))
    reader.Update()
    check(reader.GetErrorCode() == 0, f"VTK's error {reader.GetErrorCode()} in {path}")
    return reader.GetOutput()


def words(data, name):
    array = data.GetFieldData().GetAbstractArray(name)
    return [array.GetValue(k) for k in range(array.GetNumberOfValues())]


def number(data, name):
    return data.GetFieldData().GetArray(name).GetValue(0)


def posed(model, i, j):
    """Both bodies and the patella in world W at a cell, of a right knee: Rx(-varus) Rz(flexion) about the rotation centre."""
    centre = model.attrs["rotation_centre_mm"]
    R = turned("x", -model["varus"][j]) @ turned("z", model["flexion"][i])
    X = model["X_reference_moving"][i, j]
    moving = vertices(model, "moving") @ X[:3, :3].T + X[:3, 3]
    patella, X = model["followers/patella/body/vertices"][()], model["followers/patella/X_of_follower"][i, j]
    return [(p - centre) @ R.T for p in (vertices(model, "reference"), moving, patella @ X[:3, :3].T + X[:3, 3])]


def check_bodies(data, model, i, j):
    points = vtk_to_numpy(data.GetPoints().GetData())
    check(numpy.abs(points - numpy.concatenate(posed(model, i, j))).max() < SINGLE_MM, "the bodies are elsewhere")
    body = vtk_to_numpy(data.GetCellData().GetArray("body"))
    for number_of, name in enumerate(("reference", "moving")):
        group = model[f"bodies/{name}"]
        n = len(group["triangles"]) + (len(group["visual/triangles"]) if "visual" in group else 0)
        check((body == number_of).sum() == n, f"another number of triangles in {name}")
    names = words(data, "component_name")
    component = vtk_to_numpy(data.GetCellData().GetArray("component"))
    own = [f"{model['bodies/moving'].attrs['name'][0]}/{name.decode()}" for name in model["bodies/moving/component_name"][:]]
    expected = numpy.array(own)[model["bodies/moving/component"][:]]
    first = numpy.flatnonzero(body == 1)[0]
    check((numpy.array(names)[component[first:first + len(expected)]] == expected).all(), "other components")
    material = vtk_to_numpy(data.GetCellData().GetArray("material"))
    check({words(data, "material_name")[m] for m in set(material)} == {"bone", "meniscus"}, "other materials")


def distances(data, body, points):
    """Distances of points to the surface of one posed body, by VTK."""
    threshold = vtk.vtkThreshold()
    threshold.SetInputData(data)
    threshold.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_CELLS, "body")
    threshold.SetLowerThreshold(body)
    threshold.SetUpperThreshold(body)
    surface = vtk.vtkGeometryFilter()
    surface.SetInputConnection(threshold.GetOutputPort())
    surface.Update()
    distance = vtk.vtkImplicitPolyDataDistance()
    distance.SetInput(surface.GetOutput())
    return numpy.array([abs(distance.EvaluateFunction(point)) for point in points])


def check_contacts(data, bodies, model, cell):
    rows = model["contacts/row_start"][cell:cell + 2]
    points = vtk_to_numpy(data.GetPoints().GetData())
    check(len(points) == rows[1] - rows[0] and len(points) > 0, "another number of contacts")
    check(data.GetNumberOfVerts() == len(points), "points that are not drawn")
    check(distances(bodies, 0, points).max() < TOUCH_MM, "contacts off the reference")
    reach = vtk_to_numpy(data.GetPointData().GetArray("distance_mm"))
    check((distances(bodies, 1, points) < reach + TOUCH_MM).all(), "contacts off the moving body")
    normals = vtk_to_numpy(data.GetPointData().GetNormals())
    check((normals[:, 1] < 0).all(), "a reaction that does not push the tibia away from the femur")


def check_vtk(vrda, file, folder):
    pvd = folder / "a & b" / "knee.pvd"
    done = run(vrda, "export", file, "--to", "vtk", "--set", "raw", "--varus", "spine", "-o", pvd, "--json")
    said = json.loads(done.stdout)
    entries = xml.etree.ElementTree.parse(pvd).getroot().findall("Collection/DataSet")
    check(len(said["files"]) == len(entries) + 1, "another number of files than it says")
    parts = {(float(e.get("timestep")), int(e.get("part"))): read_vtp(pvd.parent / e.get("file")) for e in entries}
    check(sorted(parts) == [(f, part) for f in FLEXIONS for part in (0, 1)], f"other files: {sorted(parts)}")
    with h5py.File(file) as model:
        for i, flexion in enumerate(FLEXIONS):
            j = int(numpy.argmax(model["is_spine"][i]))
            bodies, contacts = parts[flexion, 0], parts[flexion, 1]
            check(number(bodies, "flexion_deg") == flexion, "another flexion")
            check(abs(number(bodies, "varus_deg") - model["varus"][j]) < 1e-9, "another varus")
            check(abs(number(bodies, "lateral_mm") - model["clinical/lateral"][i, j]) < 1e-9, "another translation")
            check_bodies(bodies, model, i, j)
            check_contacts(contacts, bodies, model, i * len(model["varus"]) + j)


def check_csv(vrda, file, folder):
    run(vrda, "export", file, "--to", "csv", "--full", "-o", folder / "cells.csv")
    cells = pandas.read_csv(folder / "cells.csv", float_precision="round_trip")
    run(vrda, "export", file, "--to", "csv", "--set", "raw", "--varus", "1", "-o", folder / "knee.csv")
    knee = pandas.read_csv(folder / "knee.csv")
    with h5py.File(file) as model:
        for column, name in (("ty_mm", "ty"), ("theta_deg", "theta"), ("gap_medial_mm", "gap_medial_mm"),
                             ("internal_rotation_deg", "clinical/internal_rotation"), ("degree_2_tx_mm", "smoothed/degree_2/tx")):
            check(numpy.array_equal(cells[column], model[name][:].ravel(), equal_nan=True), f"another {column}")
        check((cells.status == "stable").all(), "other statuses")
        check(numpy.abs(knee.varus_deg - 1).max() < 1e-9, "another varus")
        j = list(model["varus"][:]).index(1)
        for column, name in (("internal_deg", "internal_rotation"), ("anterior_mm", "anterior")):
            check(numpy.abs(knee[column] - model[f"clinical/{name}"][:, j]).max() < 1e-9, f"another {column} of a flexion")


def check_sto(vrda, file, folder):
    run(vrda, "export", file, "--to", "mot", "--set", "raw", "--varus", "spine", "--degrees", "--rate", "45", "--coordinate",
        "flexion=knee_angle_r", "-o", folder / "knee.mot")
    text = (folder / "knee.mot").read_text()
    header = text[:text.index("endheader")]
    table = pandas.read_csv(folder / "knee.mot", sep="\t", skiprows=header.count("\n") + 1, float_precision="round_trip")
    keys = dict(re.findall(r"(\w+)=(.+)", header))
    centre = numpy.array([float(word) for word in keys.pop("rotation_centre_mm").split()])
    check(keys == {"version": "1", "nRows": "4", "nColumns": "13", "inDegrees": "yes", "translations": "rotation-centre"}, f"another header: {keys}")
    check(table.shape == (4, 13) and list(table.columns[:2]) == ["time", "knee_angle_r"], "another table")
    check(numpy.allclose(table.time, numpy.array(FLEXIONS) / 45, atol=1e-12), "another clock")
    with h5py.File(file) as model:
        for i in range(4):
            X = model["X_reference_moving"][i, int(numpy.argmax(model["is_spine"][i]))]
            row = table.iloc[i]
            R = turned("z", -row.knee_angle_r) @ turned("x", row.knee_add_r) @ turned("y", row.knee_rot_r)
            check(numpy.abs(R - X[:3, :3]).max() < 1e-12, "the angles make another pose")
            t_mm = 1e3 * row[["knee_tx_r", "knee_ty_r", "knee_tz_r"]].to_numpy()
            check(numpy.abs(t_mm - (X[:3, :3] @ centre + X[:3, 3] - centre)).max() < 1e-9, "another translation")
            kneecap = model["followers/patella"]
            j = int(numpy.argmax(model["is_spine"][i]))
            check(abs(row.follower_patella_tilt_deg - kneecap["tilt"][i, j]) < 1e-9, "another tilt")
            check(abs(1e3 * row.follower_patella_proximal_m - kneecap["proximal"][i, j]) < 1e-9, "another place of the kneecap")


def check_groups(file):
    """Groups carry the coordinates of their tables, in both readers of netCDF."""
    for engine in ("netcdf4", "h5netcdf"):
        with xarray.open_dataset(file, group="clinical", engine=engine) as clinical, xarray.open_dataset(file, engine=engine) as whole:
            check(list(clinical.coords) == ["flexion", "varus"], f"{engine}: no coordinates in the group")
            chosen = clinical.sel(flexion=30, varus=1)
            check(float(chosen.internal_rotation) == float(clinical.internal_rotation[1, 2]), f"{engine}: another cell")
            check(whole.sizes["flexion"] == 4, f"{engine}: another grid")
    header = run("ncdump", "-h", file).stdout
    check("double flexion(flexion)" in header, "ncdump reads no coordinates")


def check_notebook(file, folder):
    picture = folder / "screw-home.png"
    done = run(sys.executable, ROOT / "scripts/open_in_python", file, picture)
    check("internal rotation over" in done.stdout, "the notebook printed nothing")
    with PIL.Image.open(picture) as image:
        colours = image.convert("RGB").getcolors(1 << 24)
    check(len(colours) > 20, "an empty picture")


def main():
    vrda = sys.argv[1]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        file = folder / "knee.h5"
        run(vrda, "run", ROOT / "jobs/knee-generic.toml", "-o", file, "--progress", "none", "--set",
            "grid.flexion.step=30", "--set", "grid.varus={ from = -1, to = 1, step = 1 }", "--set", "smooth.degrees=[2]")
        check_vtk(vrda, file, folder)
        check_csv(vrda, file, folder)
        check_sto(vrda, file, folder)
        check_groups(file)
        check_notebook(file, folder)
    print("VTK, pandas and the notebook read what vrda writes")


if __name__ == "__main__":
    main()
