"""Builds the wheel of the Python package vrda for pip (PEP 517): the files that `cmake --install` has, for the Python that builds it.

Needs the Debian packages of scripts/setup programs python, and no network.
"""
import pathlib
import re
import subprocess
import sys
import sysconfig
import tempfile

from wheel.wheelfile import WheelFile

ROOT = pathlib.Path(__file__).resolve().parent.parent
VERSION = re.search(r"project\(vrda VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)
NAME = f"vrda-{VERSION}"
PYTHON = f"cp{sys.version_info.major}{sys.version_info.minor}"
TAG = f"{PYTHON}-{PYTHON}-{re.sub('[-.]', '_', sysconfig.get_platform())}"
METADATA = f"""Metadata-Version: 2.1
Name: vrda
Version: {VERSION}
Summary: The motion of a joint from the surfaces of its bones
License: BSD-3-Clause
Requires-Python: >=3.11
Requires-Dist: numpy
Provides-Extra: xarray
Requires-Dist: xarray; extra == "xarray"
Requires-Dist: h5netcdf; extra == "xarray"
"""
FILES = {"METADATA": METADATA, "WHEEL": f"Wheel-Version: 1.0\nGenerator: vrda\nRoot-Is-Purelib: false\nTag: {TAG}\n"}
BUILD = """
source scripts/steps.sh
configure_release -DVRDA_PYTHON=ON
cmake --build "$release" --parallel "$(nproc)" --target vrda_python
cmake --install "$release" --component python --strip --prefix "$1"
"""


def get_requires_for_build_wheel(config_settings=None):
    """Nothing but what pyproject.toml names."""
    return []


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Writes the metadata without building."""
    folder = pathlib.Path(metadata_directory, f"{NAME}.dist-info")
    folder.mkdir()
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Builds the extension module in build/release and packs the package; returns the wheel's name."""
    name = f"{NAME}-{TAG}.whl"
    with tempfile.TemporaryDirectory() as prefix:
        if subprocess.run(["bash", "-c", BUILD, "scripts/python_wheel.py", prefix], cwd=ROOT, check=False).returncode != 0:
            sys.exit("vrda: found a failed build, wanted the packages of scripts/setup programs python; the reason is above")
        package = next(pathlib.Path(prefix).glob("lib/python3/*/vrda"))
        if not (package / f"_core{sysconfig.get_config_var('EXT_SUFFIX')}").is_file():
            sys.exit(f"vrda: found Python {sys.version.split()[0]} of {sys.executable}, wanted the system's, /usr/bin/python3, "
                     "for which the module is built")
        with WheelFile(pathlib.Path(wheel_directory, name), "w") as wheel:
            for file in sorted(package.iterdir()):
                wheel.write(str(file), f"vrda/{file.name}")
            for file, text in FILES.items():
                wheel.writestr(f"{NAME}.dist-info/{file}", text)
    return name
