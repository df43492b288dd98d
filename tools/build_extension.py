"""Build the Blender extension by Blender's own builder, with retime's wheel inside; ``make extension`` runs it.

Two files come of it: one for this platform, with the compiled kernels, and one for any, with NumPy's alone. Blender 4.2
to 5.0 run Python 3.11, for which a wheel is built only by 3.11; with another Python there is the second file only.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "blender"
OUT = ROOT / "build" / "extension"
# What Blender's site takes with ease, and a person on a train.
MOST_BYTES = 3_000_000


def builder_in(environment: Path) -> Path:
    """Find Blender's builder in an environment that has bpy."""
    found = sorted(environment.glob("lib/python*/site-packages/bpy/*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))
    if not found:
        raise SystemExit(f"found no builder in {environment}: make blender")
    return found[-1]


def build_wheel(folder: Path, *, kernels: bool) -> Path:
    """Build retime's wheel, with the compiled kernels or without."""
    shutil.rmtree(folder, ignore_errors=True)
    switch = {"RETIME_REQUIRE_KERNELS": "1"} if kernels else {"RETIME_WITHOUT_KERNELS": "1"}
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir"]
    subprocess.run([*command, str(folder), str(ROOT)], env={**os.environ, **switch}, check=True)
    return next(folder.glob("*.whl"))


def stage(folder: Path, wheel: Path, platform: str | None) -> None:
    """Lay out what the builder packs: the extension, its licence, the wheel, and a manifest that names it."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(SOURCE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "LICENSE", folder)
    (folder / "wheels").mkdir()
    shutil.copy(wheel, folder / "wheels")
    place = folder / "blender_manifest.toml"
    manifest = place.read_text(encoding="utf-8")
    told = f'wheels = ["./wheels/{wheel.name}"]\n'
    if platform is not None:
        told += f'platforms = ["{platform}"]\n'
    # Tables end the manifest's own part.
    place.write_text(manifest.replace("\n[permissions]", f"{told}\n[permissions]", 1), encoding="utf-8")


def platform_of(wheel: Path) -> str:
    """Say how Blender calls the platform of a compiled wheel."""
    tag = wheel.stem.rsplit("-", 1)[-1]
    for pattern, name in (
        (r"(many)?linux.*x86_64", "linux-x64"),
        (r"(many)?linux.*aarch64", "linux-arm64"),
        (r"macosx.*arm64", "macos-arm64"),
        (r"macosx.*x86_64", "macos-x64"),
        (r"win_amd64", "windows-x64"),
        (r"win_arm64", "windows-arm64"),
    ):
        if re.fullmatch(pattern, tag):
            return name
    raise SystemExit(f"Blender has no name for the platform of {wheel.name}")


def pack(builder: Path, staged: Path, zipped: Path) -> None:
    """Build the extension and validate it."""
    zipped.unlink(missing_ok=True)
    for command in (
        ["build", "--source-dir", str(staged), "--output-filepath", str(zipped)],
        ["validate", str(zipped)],
    ):
        subprocess.run([sys.executable, str(builder), *command], check=True, stdout=subprocess.DEVNULL)
    size = zipped.stat().st_size
    if size > MOST_BYTES:
        raise SystemExit(f"{zipped.name} has {size / 1e6:.1f} MB; {MOST_BYTES / 1e6:g} are the most")
    print(f"{zipped.relative_to(ROOT)}: {size / 1e6:.2f} MB")


def main() -> None:
    """Build what this Python can."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("environment", type=Path, help="an environment with bpy, which has Blender's builder")
    builder = builder_in(parser.parse_args().environment)
    version = tomllib.loads((SOURCE / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]
    ours = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    if version != ours:
        raise SystemExit(
            f"the extension calls itself {version}, retime {ours}: make blender/blender_manifest.toml agree"
        )
    if sys.version_info[:2] == (3, 11):
        wheel = build_wheel(OUT / "compiled", kernels=True)
        platform = platform_of(wheel)
        stage(OUT / "staged", wheel, platform)
        pack(builder, OUT / "staged", OUT / f"retime-{version}-{platform.replace('-', '_')}.zip")
    else:
        print(f"Python {sys.version_info[0]}.{sys.version_info[1]} builds no kernels for Blender's 3.11")
    wheel = build_wheel(OUT / "pure", kernels=False)
    stage(OUT / "staged", wheel, None)
    pack(builder, OUT / "staged", OUT / f"retime-{version}.zip")


if __name__ == "__main__":
    main()
