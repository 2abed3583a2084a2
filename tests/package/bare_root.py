"""A root file system with only glibc, to run programs in: everything else a tarball needs must be included in it."""
import functools
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

import release

# A separate mount namespace: mounts are not visible outside and end with the process.
OWN_MOUNTS = ["unshare", "--mount", "--propagation", "private"]


def own_mounts():
    return OWN_MOUNTS if os.getuid() == 0 else [*OWN_MOUNTS, "--user", "--map-root-user"]


@functools.cache
def refusal():
    """Why chroot is not possible here; empty if it is."""
    if not shutil.which("unshare") or not shutil.which("chroot"):
        return "no unshare or no chroot"
    with tempfile.TemporaryDirectory() as folder:
        probe = [*own_mounts(), "sh", "-c", 'mount --rbind /proc "$0" && chroot / /bin/true', folder]
        done = subprocess.run(probe, capture_output=True, text=True, stdin=subprocess.DEVNULL, check=False)
    return "" if done.returncode == 0 else f"neither root nor a user namespace: {done.stderr.strip()}"


def glibc_files():
    """The loader and the shared libraries of the package libc6, as the system has them."""
    listed = release.run("dpkg-query", "--listfiles", "libc6").splitlines()
    return [pathlib.Path(path) for path in listed if re.search(r"/(lib[\w.-]+\.so\.\d+|ld-linux[\w.-]+\.so\.\d+)$", path)
            and "/gconv/" not in path]


def make(folder):
    """Fills the folder with glibc's files; returns its contents by path."""
    for path in glibc_files():
        target = folder / str(path).lstrip("/")
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, target)
    for empty in ("dev", "proc", "tmp"):
        (folder / empty).mkdir()
    return release.files_below(folder)


def run(folder, *command):
    """Runs a command inside; of the system only /proc and /dev are visible."""
    enter = 'mount --rbind /proc "$0/proc" && mount --rbind /dev "$0/dev" && exec "$(command -v env)" -i PATH=/bin HOME=/tmp "$(command -v chroot)" "$0" "$@"'
    return release.run(*own_mounts(), "sh", "-c", enter, folder, *command)
