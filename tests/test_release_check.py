"""What `make release-check` looks for in an sdist and in wheels, and what it would not let pass."""

from __future__ import annotations

import io
import tarfile
import zipfile
from pathlib import Path

import pytest

from tests.tool_modules import tool

release_check = tool("release_check")
INFO = "retime-1.2.3.dist-info"
METADATA = "Metadata-Version: 2.2\nName: retime\nVersion: 1.2.3\nRequires-Python: >=3.11\n"


def wheel(folder: Path, name: str, *, without: str = "", metadata: str = METADATA, **more: str) -> Path:
    path = folder / name
    with zipfile.ZipFile(path, "w") as archive:
        for member in (
            *release_check.HOLDS,
            f"{INFO}/licenses/LICENSE",
            f"{INFO}/licenses/THIRD_PARTY.md",
            *more.values(),
        ):
            if member != without:
                archive.writestr(member, "")
        archive.writestr(f"{INFO}/METADATA", metadata)
    return path


def test_a_sound_wheel_has_no_faults(tmp_path) -> None:
    pure = wheel(tmp_path, "retime-1.2.3-py3-none-any.whl")
    assert release_check.faults_of_wheel(pure, "1.2.3", compiled=False) == []
    name = "retime-1.2.3-cp312-abi3-linux_x86_64.whl"
    compiled = wheel(tmp_path, name, kernels="retime/kernels/_kernels.abi3.so")
    assert release_check.faults_of_wheel(compiled, "1.2.3", compiled=True) == []


@pytest.mark.parametrize(
    ("given", "fault"),
    [
        ({"without": "retime/server/page/index.html"}, "lacks retime/server/page/index.html"),
        ({"without": f"{INFO}/licenses/LICENSE"}, "lacks its licence"),
        ({"without": f"{INFO}/licenses/THIRD_PARTY.md"}, "lacks its licence"),
        ({"metadata": METADATA.replace("1.2.3", "1.2.4")}, "says another version"),
        ({"more": "retime/kernels/module.cpp"}, "holds retime/kernels/module.cpp"),
        ({"more": "tests/conftest.py"}, "holds tests/conftest.py"),
        ({"more": "retime/kernels/_kernels.so"}, "has kernels"),
    ],
)
def test_what_is_wrong_with_a_wheel_is_said(tmp_path, given, fault) -> None:
    path = wheel(tmp_path, "retime-1.2.3-py3-none-any.whl", **given)
    (found,) = release_check.faults_of_wheel(path, "1.2.3", compiled=False)
    assert found.startswith(fault)


def test_a_wheel_that_should_have_kernels_and_has_none_is_found(tmp_path) -> None:
    path = wheel(tmp_path, "retime-1.2.3-cp311-cp311-linux_x86_64.whl")
    assert release_check.faults_of_wheel(path, "1.2.3", compiled=True) == ["has no kernels"]
    assert release_check.faults_of_wheel(path, "1.2.3", compiled=False) == [f"is called {path.name}"]


def test_what_is_wrong_with_an_sdist_is_said(tmp_path) -> None:
    path = tmp_path / "retime-1.2.3.tar.gz"
    with tarfile.open(path, "w:gz") as archive:
        for name in (
            *("pyproject.toml", "README.md", "LICENSE", "CMakeLists.txt", "tools/build_backend.py", "PKG-INFO"),
            *(".git/HEAD", "out.txt"),
        ):
            member = tarfile.TarInfo(f"retime-1.2.3/{name}")
            archive.addfile(member, io.BytesIO(b""))
    faults = release_check.faults_of_sdist(path, "1.2.3")
    assert "lacks src/retime/server/page/index.html" in faults
    assert "lacks src/retime/kernels/module.cpp" in faults
    assert "holds .git/HEAD" in faults
    assert [fault for fault in faults if "nobody put" in fault] == [
        "holds .git, which nobody put there",
        "holds out.txt, which nobody put there",
    ]
    assert release_check.faults_of_sdist(path, "1.2.4")[-1] == "is called retime-1.2.3.tar.gz"
