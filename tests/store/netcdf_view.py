"""Opens a sample motion model, a trace and an index with the programs that its readers use: netCDF's ncdump, h5dump, and xarray
with both of its engines. Wants named dimensions with units and not one warning.

usage: netcdf_view.py WRITE_SAMPLE
exit: 0 all is well, 1 a finding (printed), 77 skipped because a program or package is absent
"""
import importlib
import os
import shutil
import subprocess
import sys
import tempfile
import warnings

SKIPPED = 77
GROUPS = {
    "/": {"flexion", "varus", "row", "column"},
    "/clinical": {"flexion", "varus"},
    "/contacts": {"contact", "cell_bound", "xyz"},
    "/bodies/reference": {"member", "vertex", "triangle", "xyz", "corner"},
    "/bodies/moving/visual": {"vertex", "triangle", "xyz", "corner"},
    "/push": {"flexion", "xyz"},
    "/contact_paths": {"flexion", "varus", "xyz"},
    "/equilibrium": {"flexion", "varus", "xyz"},
    "/equilibrium/forces": {"force", "cell_bound", "xyz"},
    "/equilibrium/spine": {"flexion"},
    "/ligaments": {"flexion", "varus", "fibre", "wrapping", "xyz", "row", "column"},
    "/uncertainty": {"sample", "draw", "flexion", "angle", "direction", "compartment", "quantile", "quantity", "fibre"},
    "/smoothed/degree_1": {"flexion", "varus", "term", "axis"},
    "/zero_varus": {"flexion", "interval", "sagittal", "xyz", "row", "column"},
    "/audit/raw": {"flexion", "varus"},
    "/audit/degree_1_recontacted": {"flexion", "varus"},
    "/job": {"input"},
}

TRACE_GROUPS = {
    "/searches": {"search", "search_bound", "xyz"},
    "/moves": {"move", "move_bound", "xyz"},
    "/contacts": {"contact", "xyz"},
    "/job": {"input"},
}


def skip(why):
    print("skipped: " + why)
    sys.exit(SKIPPED)


def check(condition, why):
    if not condition:
        print("wrong: " + why)
        sys.exit(1)


def run(*command, **environment):
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment}, check=False)
    check(done.returncode == 0 and not done.stderr, f"{command[0]} ended with {done.returncode}: {done.stderr}")
    return done.stdout


def check_ncdump(path):
    header = run("ncdump", "-h", path)
    for line in (
        "flexion = 91 ;",
        "varus = 21 ;",
        "double tx(flexion, varus) ;",
        'string tx:units = "mm" ;',
        'string theta:units = "degree" ;',
        'string flexion:units = "degree" ;',
        "double X_reference_moving(flexion, varus, row, column) ;",
        "byte status(flexion, varus) ;",
        "status:flag_values = -1b, 0b, 1b, 2b, 3b, 4b, 5b ;",
        'string status:flag_meanings = "pending stable no_contact no_clearance iteration_limit unbounded overlapping" ;',
        "tx:_FillValue = NaN ;",
        'string :format = "vrda motion model" ;',
        "double point(contact, xyz) ;",
        "int triangles(triangle, corner) ;",
        "double tension(flexion, varus, fibre) ;",
        'string tension:units = "N" ;',
        'string energy:units = "N mm" ;',
        "double X_body_wrap(wrapping, row, column) ;",
        'string wrap_shape:flag_meanings = "cylinder ellipsoid" ;',
        "double varus_solved(flexion, varus) ;",
        "double recontact(flexion, varus) ;",
        'string source:flag_meanings = "none both_touch interpolated free" ;',
        "double instant_centre(interval, sagittal) ;",
        'string state:flag_meanings = "no_pose free overlapping nothing_ahead" ;',
        "flexion = 181 ;",
        "largest_penetration = 33.75 ;",
    ):
        check(line in header, f"`{line}` is not in the output of ncdump -h")
    check("phony_dim" not in header, "a dimension without a name in the output of ncdump -h")
    run("ncdump", "-v", "status", path)


def check_h5dump(path):
    check("DIMENSION_LIST" in run("h5dump", "-A", "-d", "/tx", path), "h5dump shows no dimensions of /tx")
    run("h5dump", path)


def check_dataset(dataset, group, dimensions):
    check(set(dataset.sizes) == dimensions, f"{group} has the dimensions {set(dataset.sizes)}, wanted {dimensions}")
    for name, variable in dataset.variables.items():
        if variable.dtype.kind == "f":
            check(isinstance(variable.attrs.get("units"), str), f"{group}/{name} has no units")
        check(isinstance(variable.attrs.get("long_name"), str), f"{group}/{name} has no long_name")


def check_root(dataset):
    check(dataset.status.dtype == "int8", "status is no int8")
    check(list(dataset.status.attrs["flag_values"]) == [-1, 0, 1, 2, 3, 4, 5], "status has other flag_values")
    check(dataset.flexion.values.tolist() == list(range(91)), "the axis of flexion is another")
    cell = dataset.sel(flexion=30, varus=2)
    check(abs(float(cell.theta) - 6.0) < 1e-12, "theta at 30, 2 degrees is not 6 degrees")
    check(bool(dataset.tx[1, 2].isnull()) and int(dataset.status[1, 2]) == 2, "the failed cell is not NaN")
    check(dataset.attrs["title"].endswith("(genou \u00e9tal\u00f3n)"), "the title is another")
    check(list(dataset.attrs["rotation_centre_mm"]) == [1.0, -2.0, 3.0], "the rotation centre is another")


def check_mechanics(path, engine):
    """Groups of an equilibrium as in the specification: free spine, forces by cell, fibres by name."""
    import xarray

    spine = xarray.load_dataset(path, engine=engine, group="equilibrium/spine")
    check(spine.varus.dims == ("flexion",) and abs(float(spine.varus[2]) + 0.28) < 1e-12, "the free spine has another varus")
    check(int(spine.status[90]) == 4 and bool(spine.theta[90].isnull()), "the spine does not end unbounded")
    forces = xarray.load_dataset(path, engine=engine, group="equilibrium/forces")
    check(forces.row_start.values[:4].tolist() == [0, 2, 2, 4], "the forces have other rows")
    fibres = xarray.load_dataset(path, engine=engine, group="ligaments")
    check(str(fibres.name.values[1]) == "fibre 1", "the fibres have other names")
    tight = fibres.tension.where(fibres.bundle == "ACL").max(("flexion", "varus"))
    check(float(tight[4]) > 0 and float(tight[2]) == 0 and bool(tight[1].isnull()), "other fibres are tight")


def check_derived(path, engine):
    """Derived groups as in the specification: a motion over flexion only, and audits on their own grids."""
    import numpy
    import xarray

    motion = xarray.load_dataset(path, engine=engine, group="zero_varus")
    check(motion.internal_rotation.dims == ("flexion",), "internal rotation of the zero-varus motion is not over flexion")
    check(motion.source.values[:3].tolist() == [0, 1, 0], "the zero-varus motion has other sources")
    check(bool(motion.varus_first[1].isnull()) and float(motion.varus_last[2]) == -0.5, "the zero varus has other bounds")
    check(motion.helical_direction.shape == (90, 3), "the helical axes are not between the flexions")
    audit = xarray.load_dataset(path, engine=engine, group="audit/raw")
    check(audit.flexion.values.tolist() == [i / 2 for i in range(181)], "the audit's axis of flexion is another")
    cell = audit.sel(flexion=1.0, varus=-0.5)
    check(int(cell.state) == 2 and bool(cell.gap.isnull()), "the audit's state is another")
    check(int(numpy.atleast_1d(audit.attrs["refine"])[0]) == 2, "the audit has another refinement")
    check(float(audit.penetration.max()) == float(audit.attrs["largest_penetration"]), "the largest penetration is another")


def check_free(path):
    """With one column there is a surface of the varus found, whose name differs from all coordinates."""
    import xarray

    for engine in ("netcdf4", "h5netcdf"):
        with xarray.open_dataset(path, engine=engine, group="smoothed/degree_1") as dataset:
            check_dataset(dataset.load(), "/smoothed/degree_1", GROUPS["/smoothed/degree_1"])
            check(dataset.varus_solved.dims == ("flexion", "varus"), "the smoothed varus has other dimensions")
            check(dataset.coefficients_varus_solved.attrs["units"] == "degree", "the smoothed varus is not in degrees")


def check_xarray(path):
    # Modules warn about versions on import; only warnings caused by the file count.
    for module in ("h5py", "netCDF4", "h5netcdf", "pandas", "xarray"):
        try:
            importlib.import_module(module)
        except ImportError:
            skip(f"{sys.executable} has no {module} (Debian: python3-{module.lower()})")
    import xarray

    warnings.simplefilter("error")
    with xarray.open_dataset(path) as dataset:
        check_root(dataset.load())
    for engine in ("netcdf4", "h5netcdf"):
        for group, dimensions in GROUPS.items():
            with xarray.open_dataset(path, engine=engine, group=group) as dataset:
                check_dataset(dataset.load(), group, dimensions)
        with xarray.open_dataset(path, engine=engine) as dataset:
            check_root(dataset.load())
        check_mechanics(path, engine)
        check_derived(path, engine)


def check_trace(path):
    """Reads the trace as shown in schemas/trace.md."""
    import xarray

    header = run("ncdump", "-h", path)
    check("phony_dim" not in header, "a dimension without a name in the trace")
    check('kind:flag_meanings = "retreat approach bisect rotate translate iterate trial"' in header, "the kinds have no meanings")
    for engine in ("netcdf4", "h5netcdf"):
        for group, dimensions in TRACE_GROUPS.items():
            with xarray.open_dataset(path, engine=engine, group=group) as dataset:
                check_dataset(dataset.load(), group, dimensions)
    searches = xarray.load_dataset(path, group="searches")
    moves = xarray.load_dataset(path, group="moves")
    check(str(moves.translation.dtype) == "float32", "poses of moves are not float32")
    k = int(((searches.flexion == 0) & (searches.varus == 1) & (searches.node != 0)).argmax("search"))
    search = moves.isel(move=slice(int(searches.move_start[k]), int(searches.move_start[k + 1])))
    path_in_contact = search.translation.where(search.in_contact == 1, drop=True)
    check(path_in_contact.shape == (3, 3), f"{path_in_contact.shape[0]} moves in contact, wanted 3")


def check_index(path):
    """One row per case, by name; codes with their meanings; a table that pandas reads directly."""
    import xarray

    header = run("ncdump", "-h", path)
    check("case = 3 ;" in header and "string case(case) ;" in header, "the cases are no dimension of the index")
    check('gap_mm:units = "mm" ;' in header and "phony_dim" not in header, "the index has no units or no dimensions")
    for engine in ("netcdf4", "h5netcdf"):
        with xarray.open_dataset(path, engine=engine) as dataset:
            index = dataset.load()
        check_dataset(index, "/", {"case"})
        check(index.case.values.tolist() == ["a_rest", "a_search", "b_rest"], "the index has other cases")
        check(float(index.gap_mm.sel(case="a_rest")) == 0.125, "a case is not found by its name")
        check(bool(index.gap_mm.sel(case="a_search").isnull()), "no answer is not NaN")
        frame = index.to_dataframe()
        check(frame.shape == (3, 3) and frame.loc["b_rest", "status"] == 3, "pandas sees another table")


def check_same_bytes(write_sample, folder, kind):
    contents = set()
    # Detects uninitialised memory: glibc fills it with the given byte.
    for byte in ("0", "85", "170"):
        path = os.path.join(folder, f"{kind}-{byte}.h5")
        run(write_sample, path, kind, MALLOC_PERTURB_=byte)
        with open(path, "rb") as file:
            contents.add(file.read())
    check(len(contents) == 1, f"equal samples gave different bytes ({kind})")


def main():
    write_sample = sys.argv[1]
    for program in ("ncdump", "h5dump"):
        if shutil.which(program) is None:
            skip(f"no {program} (Debian: netcdf-bin, hdf5-tools)")
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("rich", "trace", "index"):
            check_same_bytes(write_sample, folder, kind)
        path = os.path.join(folder, "knee.h5")
        run(write_sample, path, "rich")
        check_ncdump(path)
        check_h5dump(path)
        check_xarray(path)
        trace = os.path.join(folder, "knee.trace.h5")
        run(write_sample, trace, "trace")
        check_trace(trace)
        index = os.path.join(folder, "index.h5")
        run(write_sample, index, "index")
        check_index(index)
        free = os.path.join(folder, "free.h5")
        run(write_sample, free, "free")
        check_free(free)
        for kind in ("plain", "pending"):
            other = os.path.join(folder, kind + ".h5")
            run(write_sample, other, kind)
            check("phony_dim" not in run("ncdump", "-h", other), f"a dimension without a name ({kind})")
            import xarray

            with xarray.open_dataset(other) as dataset:
                check(set(dataset.load().sizes) == GROUPS["/"], f"other dimensions ({kind})")
        # The pending model has no forces, and its fibres have no wraps.
        for group in ("/equilibrium", "/equilibrium/forces", "/equilibrium/spine", "/ligaments"):
            for engine in ("netcdf4", "h5netcdf"):
                with xarray.open_dataset(os.path.join(folder, "pending.h5"), engine=engine, group=group) as dataset:
                    check_dataset(dataset.load(), group, GROUPS[group])
    print("ncdump, h5dump and xarray see named dimensions with units")


if __name__ == "__main__":
    main()
