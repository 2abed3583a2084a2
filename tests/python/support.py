"""Jobs for the tests of the Python module, and the program that was built with it."""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
VRDA = sys.argv[1]
# 26 fibres; a free varus and flexion 0 to 90 by 15 take half a second.
KNEE = ROOT / "jobs/knee-generic.toml"
COARSE = {"grid.flexion": {"from": 0, "to": 90, "step": 15}, "grid.varus": "free", "solver.equilibrium.restarts": 0}
