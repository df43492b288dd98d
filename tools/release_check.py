"""Build what a release puts on the index, and use it as a stranger would: ``python tools/release_check.py [FOLDER]``.

Into FOLDER (build/release) go the sdist, a wheel with kernels for this Python and system where a compiler works, and
the wheel of Python alone; both are built from the sdist, as pip does. Each is looked into, and installed in a fresh
environment with nothing else, where the tutorial is followed from start to end.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# What every wheel holds, and what none does.
HOLDS = (
    "retime/__init__.py",
    "retime/py.typed",
    "retime/data/sample.bvh",
    "retime/server/page/index.html",
    "retime/server/page/widget.js",
)
SOURCES = (
    *("pyproject.toml", "README.md", "LICENSE", "CMakeLists.txt", "tools/build_backend.py"),
    *("src/retime/kernels/module.cpp", "src/retime/server/page/index.html"),
)
# What else an sdist holds at its top, or begins there; a stranger's file in the checkout is none of it.
TOP = (
    *(
        "PKG-INFO",
        "CHANGELOG.md",
        "CITATION.cff",
        "CODE_OF_CONDUCT.md",
        "CONTRIBUTING.md",
        "SECURITY.md",
        "THIRD_PARTY.md",
    ),
    *("Makefile", "conftest.py", ".clang-format", ".gitignore", ".pre-commit-config.yaml"),
    *(".github", "examples", "src", "tools", "web"),
)
NEVER = ("tests/", "study/", "docs/", "web/", ".cpp", ".hpp", ".map", "node_modules")


def run(*command: str | Path, **environment: str) -> None:
    """Run a command; raise CalledProcessError where it fails."""
    subprocess.run([str(word) for word in command], check=True, cwd=ROOT, env={**os.environ, **environment})


def build_sdist(folder: Path) -> Path:
    """Build the sdist, with the page in it."""
    code = "import sys; sys.path.insert(0, 'tools'); import build_backend; build_backend.build_sdist(sys.argv[1])"
    run(sys.executable, "-c", code, folder, RETIME_REQUIRE_PAGE="1")
    (sdist,) = folder.glob("retime-*.tar.gz")
    return sdist


def build_wheel(sdist: Path, folder: Path, **environment: str) -> Path:
    """Build a wheel of the sdist."""
    before = set(folder.glob("*.whl"))
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-cache-dir"]
    run(*pip, "--wheel-dir", folder, sdist, RETIME_REQUIRE_PAGE="1", **environment)
    (wheel,) = set(folder.glob("*.whl")) - before
    return wheel


def faults_of_sdist(sdist: Path, version: str) -> list[str]:
    """Say what is wrong with an sdist."""
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    faults = [f"lacks {name}" for name in SOURCES if name not in names]
    faults += [f"holds {name}" for name in sorted(names) if name.startswith((".git/", ".venv", "build/"))]
    faults += [f"holds {name}" for name in sorted(names) if "node_modules" in name]
    tops = {name.partition("/")[0] for name in names} - {""}
    faults += [
        f"holds {name}, which nobody put there"
        for name in sorted(tops - {*TOP, *(one.partition("/")[0] for one in SOURCES)})
    ]
    return faults + ([] if sdist.name == f"retime-{version}.tar.gz" else [f"is called {sdist.name}"])


def faults_of_wheel(wheel: Path, version: str, *, compiled: bool) -> list[str]:
    """Say what is wrong with a wheel."""
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        info = f"retime-{version}.dist-info"
        metadata = archive.read(f"{info}/METADATA").decode() if f"{info}/METADATA" in names else ""
    faults = [f"lacks {name}" for name in HOLDS if name not in names]
    faults += [f"holds {name}" for name in names if any(name.startswith(one) or name.endswith(one) for one in NEVER)]
    if not {f"{info}/licenses/LICENSE", f"{info}/licenses/THIRD_PARTY.md"} <= set(names):
        faults.append("lacks its licence, or those of others")
    if f"\nVersion: {version}\n" not in metadata or "\nRequires-Python: >=3.11\n" not in metadata:
        faults.append("says another version of itself, or of Python")
    if compiled != any("_kernels" in name and name.endswith((".so", ".pyd")) for name in names):
        faults.append("has no kernels" if compiled else "has kernels")
    if not compiled and not wheel.name.endswith("-py3-none-any.whl"):
        faults.append(f"is called {wheel.name}")
    return faults


def follow_tutorial(wheel: Path, folder: Path) -> None:
    """Install a wheel in a fresh environment, and follow the tutorial there."""
    shutil.rmtree(folder, ignore_errors=True)
    venv.create(folder, with_pip=True)
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    run(python, "-m", "pip", "install", "--quiet", "--only-binary", ":all:", wheel)
    # -I: nothing of the checkout is seen by chance.
    run(python, "-I", ROOT / "tests" / "tutorial_alone.py")


def compiles() -> bool:
    """Tell whether a compiler with Python's headers is here, as the makefile does."""
    program = "#include <Python.h>\n#include <thread>\nint main() {}\n"
    command = [os.environ.get("CXX", "c++"), "-std=c++20", f"-I{sysconfig.get_path('include')}", "-x", "c++", "-", "-o"]
    try:
        done = subprocess.run([*command, os.devnull], input=program, text=True, capture_output=True, check=False)
        return done.returncode == 0
    except OSError:
        return False


def main() -> None:
    """Build, look, install, follow."""
    folder = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else ROOT / "build" / "release"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    version: str = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    sdist = build_sdist(folder)
    faults = {sdist.name: faults_of_sdist(sdist, version)}
    wheels = {}
    if compiles():
        wheels[build_wheel(sdist, folder, RETIME_REQUIRE_KERNELS="1")] = True
    else:
        print("Found no C++20 compiler: the wheel with kernels is left out")
    wheels[build_wheel(sdist, folder, RETIME_WITHOUT_KERNELS="1")] = False
    faults |= {wheel.name: faults_of_wheel(wheel, version, compiled=compiled) for wheel, compiled in wheels.items()}
    for name, found in faults.items():
        print(
            f"{name}: {(folder / name).stat().st_size / 1e6:.1f} MB{''.join(f'{chr(10)}  {fault}' for fault in found)}"
        )
    if any(faults.values()):
        sys.exit(1)
    for wheel in wheels:
        follow_tutorial(wheel, folder / "env")
    shutil.rmtree(folder / "env")


if __name__ == "__main__":
    main()
