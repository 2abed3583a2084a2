"""Types: the package and its users pass mypy, and the stubs are those of the module. usage: types_test.py VRDA"""
import ast
import inspect
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import vrda
from vrda import _core

PACKAGE = pathlib.Path(vrda.__file__).parent
GOOD = """
import numpy as np
import vrda
joint = vrda.Job("knee.toml", set={"grid.varus": "free"}).joint()
solved: vrda.Solution = joint.solve(flexion=range(3), loads={"moment_nmm": np.zeros(3)}, seed=np.eye(4))
total: float = float(solved.internal.sum())
names: list[str] = joint.fibres
kneecap: vrda.FollowerSolution = solved.followers[joint.followers[0]]
found = vrda.open("knee.h5").theta
from typing import NamedTuple
class Mesh(NamedTuple):
    vertices: object
    faces: object
vrda.prepare(femur=Mesh([], []), tibia="tibia.stl", fibula=None).run()
"""
BAD = """
import vrda
vrda.Job(3)
vrda.Joint("knee.toml").solve(flexion=0, loads=5)
vrda.smooth("knee.h5", degree="six")
vrda.Solution().internal = 3
vrda.prepare(femur=3)
"""


CACHE = tempfile.TemporaryDirectory(prefix="vrda-mypy-")  # of NumPy's and xarray's types, for all tests


def mypy(*words, path=""):
    return subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, check=False, cwd=PACKAGE.parent,
                          env=dict(os.environ, MYPY_CACHE_DIR=CACHE.name, MYPYPATH=f"{PACKAGE.parent}:{path}"))


class Types(unittest.TestCase):
    def test_the_package_and_its_users_are_strictly_typed(self):
        with tempfile.TemporaryDirectory() as folder:
            good, bad = pathlib.Path(folder, "good.py"), pathlib.Path(folder, "bad.py")
            good.write_text(GOOD)
            bad.write_text(BAD)
            done = mypy("mypy", "--strict", "-p", "vrda", "-m", "good", "-m", "bad", path=folder)
            found = re.findall(r"(\w+\.py):(\d+): error:", done.stdout)
            self.assertEqual({line for file, line in found if file == "bad.py"}, {"3", "4", "5", "6", "7"}, done.stdout)
            self.assertEqual({file for file, _ in found}, {"bad.py"}, done.stdout)

    def test_the_stubs_are_those_of_the_module(self):
        def names_of(body):
            found = {}
            for node in body:
                if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                    found[node.name] = node
                elif isinstance(node, ast.AnnAssign):
                    found[node.target.id] = node
            return found

        def arguments(signature):
            """Names in the first line of a docstring of pybind11: "run(file: str, ...) -> str"."""
            return re.findall(r"(?:\(|, )(\w+): ", signature.splitlines()[0])

        stubs = names_of(ast.parse((PACKAGE / "_core.pyi").read_text(encoding="utf-8")).body)
        self.assertEqual(set(stubs), {name for name in vars(_core) if not name.startswith("_")} | {"__version__"})
        for name, stub in stubs.items():
            if isinstance(stub, ast.FunctionDef):
                self.assertEqual([one.arg for one in stub.args.args], arguments(getattr(_core, name).__doc__), name)
            if not isinstance(stub, ast.ClassDef):
                continue
            own = vars(getattr(_core, name))
            members = names_of(stub.body)
            self.assertEqual({one for one in members if not one.startswith("__")}, {one for one in own if not one.startswith("_")}, name)
            for member, node in members.items():
                self.assertIn(member, own, name)
                if not node.decorator_list and member != "__len__":
                    self.assertEqual([one.arg for one in node.args.args], arguments(own[member].__doc__), f"{name}.{member}")

    def test_every_public_name_has_a_docstring(self):
        for name in vrda.__all__:
            thing = getattr(vrda, name)
            if not (inspect.isclass(thing) or callable(thing)):
                continue
            self.assertTrue(inspect.getdoc(thing), name)
            for member, value in vars(thing).items() if inspect.isclass(thing) else ():
                is_documented = callable(value) or isinstance(value, property)
                if is_documented and not member.startswith("_"):
                    self.assertTrue(inspect.getdoc(value) or name == "Job", f"{name}.{member}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
