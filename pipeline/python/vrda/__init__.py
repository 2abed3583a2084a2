"""VRDA: the motion of a joint from the surfaces of its bones.

    import vrda
    job = vrda.Job("my-knee.toml")
    job.check()["warnings"]                      # as vrda check
    knee = vrda.open(job.run(progress=print))    # as vrda run: resumable, same bytes; an xarray data set
    joint = job.joint()                          # single attitudes, in memory
    joint.solve(flexion=range(0, 91), loads={"moment_nmm": 500}).internal
    vrda.prepare(femur=mesh, tibia="tibia.stl")  # a job from meshes: files, or objects with vertices and faces

Lengths are mm, angles degrees, forces N, moments N mm. Canonical axes: X anterior, Y proximal, Z to the subject's right.
Clinical numbers are those of Grood and Suntay, positive on both sides: flexion, varus (adduction), internal rotation;
anterior, proximal, lateral translation of the moving point at the rotation centre. Messages go to the logger "vrda".
Ctrl-C ends a command with KeyboardInterrupt; a run resumes when it is repeated.
"""
from __future__ import annotations

import json
import os
import pathlib
import tempfile
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Optional, Protocol, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._core import FollowerSolution, Solution, __version__
from ._errors import InputError, InternalError

if TYPE_CHECKING:
    import xarray

__all__ = ["FollowerSolution", "InputError", "InternalError", "Job", "Joint", "Solution", "SurfaceMesh", "__version__", "check", "compare",
           "export", "no_lock", "open", "prepare", "score", "smooth", "validate"]

Path = Union[str, "os.PathLike[str]"]
Array = NDArray[np.float64]


class SurfaceMesh(Protocol):
    """Any object with these two, such as a mesh of trimesh."""

    @property
    def vertices(self) -> Any:
        """(vertices, 3), in the unit and the axes of the scan."""

    @property
    def faces(self) -> Any:
        """(triangles, 3) rows of vertices, counter-clockwise from outside."""


Mesh = Union[Path, SurfaceMesh]

_LOADS = {"force_n": 1, "lateral_force_n": 2, "moment_nmm": 1, "varus_moment_nmm": 1}


def _toml(value: Any) -> str:
    """A value of a job in TOML: numbers, texts, lists, tables."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_toml(part)}" for key, part in value.items()) + "}"
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(part) for part in value) + "]"
    return json.dumps(value.item() if isinstance(value, np.generic) else value)


class Job:
    """A job file, with the keys of `set` replaced: Job("knee.toml", set={"grid.varus": "free"}).

    Raises InputError for a key that is unknown or has an invalid value. Meshes are read by check(), run() and joint().
    `data` is a folder that is searched first for input files, if given.
    """

    def __init__(self, file: Path, data: Optional[Path] = None, set: Optional[Mapping[str, Any]] = None) -> None:
        self._file = os.fspath(file)
        self._data = "" if data is None else os.fspath(data)
        self._overrides = [f"{key}={_toml(value)}" for key, value in (set or {}).items()]
        self._facts = _core.job_facts(self._file, self._overrides)

    def __repr__(self) -> str:
        return f"<vrda.Job {self._file}: {self.title}>"

    @property
    def file(self) -> pathlib.Path:
        """The job file."""
        return pathlib.Path(self._file)

    @property
    def title(self) -> str:
        """The title that the job states."""
        return self._facts["title"]

    @property
    def joint_kind(self) -> str:
        """knee, hip, ankle, subtalar or other."""
        return self._facts["joint"]

    @property
    def side(self) -> str:
        """right or left."""
        return self._facts["side"]

    @property
    def resolved(self) -> str:
        """The job with every key and default, TOML."""
        return self._facts["resolved"]

    def check(self, picture: Optional[Path] = None) -> dict[str, Any]:
        """What was understood, the plan and "warnings": the dictionary of `vrda check --json`.

        `picture`: a PNG file of the joint to write.
        """
        return _core.check(self._file, self._data, self._overrides, "" if picture is None else os.fspath(picture))

    def run(self, output: Optional[Path] = None, *, progress: Optional[Callable[[int, int], object]] = None,
            threads: int = 0, fresh: bool = False, replace: bool = False) -> pathlib.Path:
        """Solves the job as `vrda run` does, with the same bytes, and returns the path of the motion model.

        output: default results/NAME/NAME.h5. progress: called with the attitudes done and all attitudes, then likewise
        with the samples of an uncertain job, at most every 50 ms. threads: 0 is one per processor. fresh: discards an interrupted run and solves a finished job again.
        replace: allows replacing the result of another job. More unsolved attitudes than the job allows are a warning.
        """
        return pathlib.Path(_core.run(self._file, self._data, self._overrides, "" if output is None else os.fspath(output),
                                      threads, fresh, replace, progress))

    def joint(self) -> Joint:
        """The joint in memory, to solve single attitudes."""
        return Joint(self)


def check(job: Union[Job, Path]) -> dict[str, Any]:
    """Job.check() of a job or a job file."""
    return (job if isinstance(job, Job) else Job(job)).check()


class Joint:
    """The meshes, fibres and solver of a job. Arrays are read-only views of the solver's memory, canonical axes, mm.

    Raises InputError for a job with [coordinates] or [scaling].
    """

    def __init__(self, job: Union[Job, Path]) -> None:
        of = job if isinstance(job, Job) else Job(job)
        self._core = _core.JointSolver(of._file, of._data, of._overrides)

    @property
    def fibres(self) -> list[str]:
        """Names of the fibres, in the order of the columns of Solution.tension."""
        return self._core.fibres

    @property
    def followers(self) -> list[str]:
        """Names of the bodies that follow the joint (schemas/followers.md); solve() solves them too."""
        return self._core.followers

    def follower_fibres(self, follower: str) -> list[str]:
        """Names of its fibres and lines, in the order of the columns of FollowerSolution.tension."""
        return self._core.follower_fibres(follower)

    def follower_vertices(self, follower: str) -> Array:
        """(vertices, 3) mm of its contact meshes, canonical axes."""
        return self._core.follower_vertices(follower)

    def follower_triangles(self, follower: str) -> NDArray[np.int32]:
        """(triangles, 3) rows of follower_vertices(), counter-clockwise from outside."""
        return self._core.follower_triangles(follower)

    @property
    def rotation_centre(self) -> Array:
        """(3,) mm, canonical axes."""
        return self._core.rotation_centre

    @property
    def reference_vertices(self) -> Array:
        """(vertices, 3) mm of the contact meshes of the reference (femur), canonical axes."""
        return self._core.reference_vertices

    @property
    def reference_triangles(self) -> NDArray[np.int32]:
        """(triangles, 3) rows of reference_vertices, counter-clockwise from outside."""
        return self._core.reference_triangles

    @property
    def moving_vertices(self) -> Array:
        """(vertices, 3) mm of the contact meshes of the moving object (tibia), canonical axes."""
        return self._core.moving_vertices

    @property
    def moving_triangles(self) -> NDArray[np.int32]:
        """(triangles, 3) rows of moving_vertices, counter-clockwise from outside."""
        return self._core.moving_triangles

    def solve(self, flexion: Union[ArrayLike, Iterable[float]], varus: Union[ArrayLike, str] = "free",
              loads: Optional[Mapping[str, ArrayLike]] = None,
              seed: Union[None, Solution, ArrayLike] = None) -> Solution:
        """Solves attitudes in their order, each from the last stable one before it; n rows by broadcasting all arguments.

        flexion: degrees, a number or (n,). varus: degrees, a number or (n,), or "free" (equilibrium only).
        loads: replace those of [push]; each a number or (n,):
            force_n           N along Delta, above 0
            lateral_force_n   N, (2,) or (n, 2): anterior, right; at the point of the push
            moment_nmm        N mm about Delta, internal rotation positive
            varus_moment_nmm  N mm, adduction positive
        seed: a Solution, whose stable row of nearest flexion is the start, or a pose X_reference_moving (4, 4);
            default the start pose of the job. A joint may have several equilibria: the seed selects one.
        Followers are solved after the joint, from their last poses: `followers` of the result has their coordinates and
        poses by name. One with `reaction = true` pulls on the joint as in a run.
        Rows that are not stable have NaN and their reason in `status`. Other threads run while this solves.
        """
        flexion_rows = np.asarray(list(flexion) if isinstance(flexion, range) else flexion, dtype=np.float64)
        columns: dict[str, Array] = {"flexion": flexion_rows}
        if not (isinstance(varus, str) and varus == "free"):
            columns["varus"] = np.asarray(varus, dtype=np.float64)
        for name, value in (loads or {}).items():
            if name not in _LOADS:
                raise InputError(f"Joint.solve: loads.{name}: found an unknown load, wanted one of {', '.join(_LOADS)}",
                                 "Joint.solve", f"loads.{name}", "an unknown load", f"one of {', '.join(_LOADS)}")
            columns[name] = np.asarray(value, dtype=np.float64)
        rows = self._broadcast(columns)
        return self._core.solve(rows["flexion"], rows.get("varus"), rows.get("force_n"), rows.get("lateral_force_n"),
                                rows.get("moment_nmm"), rows.get("varus_moment_nmm"),
                                self._pose(seed, float(rows["flexion"][0]) if rows["flexion"].size else 0.0))

    def dataset(self, solution: Solution, follower: Optional[str] = None) -> xarray.Dataset:
        """The rows of solve(), or those of one of its followers, as an xarray data set over `row` and `fibre`.

        Its variables are the arrays of the solution, with their meanings in the attribute long_name.
        """
        import xarray

        rows: Any = solution if follower is None else solution.followers[follower]
        dimensions = {1: ("row",), 2: ("row", "fibre"), 3: ("row", "to", "from")}
        columns = {name: (getattr(rows, name), getattr(type(rows), name).__doc__) for name in dir(type(rows))
                   if not name.startswith("_") and name != "followers"}
        fibres = self.fibres if follower is None else self.follower_fibres(follower)
        return xarray.Dataset({name: (dimensions[array.ndim], array, {"long_name": meaning}) for name, (array, meaning) in columns.items()},
                              coords={"fibre": fibres}).set_coords([name for name in ("flexion", "varus") if name in columns])

    @staticmethod
    def _broadcast(columns: Mapping[str, Array]) -> dict[str, Array]:
        def refuse(name: str, array: Array, wanted: str) -> InputError:
            found = f"an array of shape {array.shape}"
            return InputError(f"Joint.solve: {name}: found {found}, wanted {wanted}", "Joint.solve", name, found, wanted)

        n = 1
        for name, array in columns.items():
            width = _LOADS.get(name, 1)
            if width == 2 and (array.ndim not in (1, 2) or array.shape[-1] != 2):
                raise refuse(name, array, "(2,) or (n, 2)")
            if width == 1 and array.ndim > 1:
                raise refuse(name, array, "a number or (n,)")
            own = array.shape[0] if array.ndim == width and array.ndim > 0 else 1
            if n not in (1, own) and own != 1:
                raise refuse(name, array, f"{n} rows or one")
            n = own if n == 1 else n
        return {name: np.ascontiguousarray(np.broadcast_to(array, (n, 2) if _LOADS.get(name, 1) == 2 else (n,)))
                for name, array in columns.items()}

    @staticmethod
    def _pose(seed: Union[None, Solution, ArrayLike], flexion: float) -> Optional[Array]:
        if seed is None:
            return None
        if not isinstance(seed, Solution):
            return np.asarray(seed, dtype=np.float64)
        distance = np.abs(seed.flexion - flexion)
        if not np.isfinite(distance).any():
            raise InputError("Joint.solve: seed: found no stable row, wanted at least one", "Joint.solve", "seed",
                             "no stable row", "at least one")
        nearest: Array = seed.X_reference_moving[int(np.nanargmin(distance))]
        return nearest


def _write_mesh(mesh: SurfaceMesh, name: str, file: pathlib.Path) -> None:
    """A binary PLY file, which keeps double precision."""
    def refuse(part: str, found: str, wanted: str) -> InputError:
        return InputError(f"vrda.prepare: {name}.{part}: found {found}, wanted {wanted}", "vrda.prepare", f"{name}.{part}", found, wanted)

    for part in ("vertices", "faces"):
        if not hasattr(mesh, part):
            raise refuse(part, f"{type(mesh).__name__} without it", "a path, or an object with vertices and faces")
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    for part, array in (("vertices", vertices), ("faces", faces)):
        if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in ("iuf" if part == "vertices" else "iu"):
            raise refuse(part, f"{array.dtype} of shape {array.shape}", "(n, 3) numbers" if part == "vertices" else "(n, 3) integers")
    triangles = np.zeros(len(faces), dtype=[("n", "u1"), ("corners", "<i4", 3)])
    triangles["n"], triangles["corners"] = 3, faces
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    file.write_bytes(header.encode() + vertices.astype("<f8").tobytes() + triangles.tobytes())


def _command(name: str, arguments: Iterable[str], options: Mapping[str, Any]) -> dict[str, Any]:
    """A command with options by name: no_prior=True is --no-prior, a list repeats the option; None and False are left out."""
    words = [name, *arguments]
    for key, value in options.items():
        if value is None or value is False:
            continue
        option = "--" + key.replace("_", "-")
        words += [option] if value is True else [f"{option}={one}" for one in (value if isinstance(value, (list, tuple)) else [value])]
    return _core.command(words)


def prepare(output: Path = "my-knee", *, femur: Optional[Mesh] = None, tibia: Optional[Mesh] = None, replace: bool = False,
            **options: Any) -> Job:
    """Makes a job from the meshes of a knee, as `vrda prepare` does, and returns it; its folder is `output`.

    A mesh is a path, or an object with vertices (n, 3) and faces (m, 3) such as trimesh's, in the unit and axes of the scan.
    options: the other options of the command, with _ for -: meshes (femur_cartilage, tibia_cartilage, meniscus, fibula,
        patella, patella_cartilage; one or a list), landmarks="points.mrk.json", side="left", unit="mm", no_ligaments=True, ...
    replace: allows replacing an earlier job in this folder. prepare.json there has the numbers of the fit; warnings go to the logger.
    """
    def file_of(value: Any, name: str) -> Any:
        """The value of an option: of a mesh in memory a file with it."""
        if isinstance(value, (list, tuple)) and not hasattr(value, "vertices"):
            return [file_of(one, f"{name}{i}") for i, one in enumerate(value)]
        if isinstance(value, (str, os.PathLike, int, float, type(None))):
            return value
        mesh: Any = value
        _write_mesh(mesh, name, pathlib.Path(folder, f"{name}.ply"))
        return pathlib.Path(folder, f"{name}.ply")

    with tempfile.TemporaryDirectory(prefix="vrda-") as folder:
        given = {name: file_of(value, name) for name, value in {"femur": femur, "tibia": tibia, **options}.items()}
        try:
            _command("prepare", [], {**given, "output": os.fspath(output), "replace": replace})
        except InputError as error:
            # Meshes in memory have no file: the message has the argument's name.
            text, file = (part.replace(folder + os.sep, "").replace(".ply", "") if folder in part else part for part in (str(error), error.file))
            raise InputError(text, file, error.field, error.found, error.wanted, error.line) from None
    return Job(pathlib.Path(output, "knee.toml"))


def score(model: Path, against: Path, **options: Any) -> dict[str, Any]:
    """Compares a motion with a measured one: the dictionary of `vrda score --json`.

    options: those of the command, with _ for -: align="rigid", rows="second-half", match="flexion", column=["flexion=-knee_angle_r"], ...
    """
    return _command("score", [os.fspath(model)], {"against": os.fspath(against), **options})


def open(file: Path, group: Optional[str] = None) -> xarray.Dataset:
    """A motion model as an xarray data set, with lazily read arrays over flexion and varus (degrees).

    Without `group`: the surfaces of the file and its clinical numbers (internal_rotation, anterior, ...), so that
    open(FILE).internal_rotation.sel(flexion=45, varus=0) works. With it: one group, e.g. "zero_varus", "ligaments".
    Raises InputError for a file that is damaged or was changed by another program. Close it as any data set.
    """
    import xarray

    name = os.fspath(file)
    _core.require_intact(name)
    if group is not None:
        return xarray.open_dataset(name, engine="h5netcdf", group=group)
    model = xarray.open_dataset(name, engine="h5netcdf")
    clinical = xarray.open_dataset(name, engine="h5netcdf", group="clinical")
    merged = model.merge(clinical)
    merged.attrs = model.attrs

    def close() -> None:
        model.close()
        clinical.close()

    merged.set_close(close)
    return merged


def validate(file: Path) -> list[tuple[str, str, str]]:
    """What in a motion model or trace violates its specification: (where, found, wanted); empty if it is valid."""
    return _core.findings(os.fspath(file))


def no_lock() -> None:
    """From now on goes on where the file system has no locks (flock), as --no-lock of the commands; models keep a warning."""
    _core.no_lock()


def smooth(file: Path, degree: int = 6, *, robust: bool = False, recontact: bool = False, threads: int = 0) -> dict[str, Any]:
    """Adds the set degree_N to a motion model, as `vrda smooth` does; returns its residuals, mm and degrees."""
    return _core.smooth(os.fspath(file), degree, robust, recontact, threads)


def compare(file: Path, degrees: Union[str, Iterable[int]] = "1..12", *, robust: bool = False, recontact: bool = False,
            refine: int = 2, threads: int = 0) -> dict[str, Any]:
    """Compares smoothing degrees without changing the file: the dictionary of `vrda compare --json`."""
    text = degrees if isinstance(degrees, str) else ",".join(str(int(degree)) for degree in degrees)
    return _core.compare(os.fspath(file), text, robust, recontact, refine, threads)


def export(file: Path, output: Path, *, to: Optional[str] = None, set: str = "", flexion: str = "",
           varus: Union[str, float] = "", coordinates: Optional[Mapping[str, str]] = None, degrees: bool = False,
           joint_only: bool = False, full: bool = False, rate: float = 30.0,
           translations: str = "rotation-centre") -> list[pathlib.Path]:
    """Writes a motion model in another program's format, as `vrda export` does; returns the files.

    to: csv, sto, mot, osim, gltf or vtk; default by the extension of `output` (.glb is gltf, .pvd is vtk).
    flexion: "FROM:TO:STEP" in degrees. varus: degrees, "spine" or "zero". The other options are those of the command.
    """
    name = os.fspath(output)
    extension = os.path.splitext(name)[1].lstrip(".")
    kind = to if to is not None else {"glb": "gltf", "pvd": "vtk"}.get(extension, extension)
    report = _core.export(os.fspath(file), kind, name, set, flexion, str(varus), [f"{key}={value}" for key, value in (coordinates or {}).items()],
                          degrees, joint_only, full, rate, translations)
    return [pathlib.Path(one) for one in report["files"]]
