"""Who may import whom.

A part of retime imports only what stands below it. Imports inside functions count too: they are as much of a
dependency, only later.
"""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "src" / "retime"
STUDY = ROOT / "study"

# What everything may use; these know nothing of the rest.
FOR_ALL = {
    "arrays",
    "brief",
    "checks",
    "child_process",
    "errors",
    "file_names",
    "frames",
    "limits",
    "progress",
    "strict_json",
    "svg",
}
# For each part, the other parts that it may import. The package itself (retime/__init__.py) is the
# table of contents and may name everything.
MAY_IMPORT = {
    **{part: set() for part in FOR_ALL},
    # Turns of joints are computed by the kernels, which know nothing of motions.
    "motion": {"kernels"},
    "kernels": set(),
    "files": set(),
    # A saved warp is a file; no other of its modules opens one. Averages over windows are computed by the kernels.
    "warp": {"motion", "files", "kernels"},
    "search": {"motion", "warp", "kernels"},
    "formats": {"motion", "warp", "files", "kernels"},
    "hosts": {"motion", "warp", "formats", "files"},
    "data": {"motion", "formats"},
    "media": {"motion", "warp", "formats", "files"},
    "evaluate": {"motion", "warp", "search", "formats", "data", "files"},
    "project": {"motion", "warp", "search", "formats", "hosts", "files"},
    # `retime edit` starts the server; nothing of the server knows the command line.
    "cli": {
        "motion",
        "warp",
        "search",
        "formats",
        "hosts",
        "kernels",
        "media",
        "evaluate",
        "project",
        "data",
        "server",
        "batch",
        "files",
        "issue_report",
    },
    # What a reader makes of a file, and the file without its names.
    "issue_report": {"motion", "formats", "files"},
    # python -m retime
    "__main__": {"cli"},
    "server": {"motion", "warp", "search", "formats", "hosts", "media", "evaluate", "project"},
    # The editor in a notebook: the server's messages and document, by another way.
    "notebook": {"motion", "warp", "search", "project", "server"},
    "batch": {"motion", "warp", "search", "formats", "evaluate", "files"},
}

# The same for the rooms of the study, which stands beside the package.
STUDY_FOR_ALL = {"defaults", "text"}
STUDY_MAY_IMPORT = {
    **{part: set() for part in STUDY_FOR_ALL},
    "clips": set(),
    "signals": set(),
    "footage": set(),
    "baselines": {"clips"},
    "answers": {"clips", "baselines"},
    "propagation": {"clips", "answers"},
    "choices": {"clips", "answers"},
    "figures": {"clips"},
    "evaluations": {"clips", "baselines", "answers", "figures"},
    "sets": {"clips", "figures"},
    "run": {"clips", "answers", "propagation", "choices", "evaluations", "sets", "signals"},
    "tables": {"answers", "propagation", "choices", "figures", "evaluations", "sets", "signals", "run"},
    "report": {"answers", "evaluations", "signals", "run", "tables"},
    "__main__": {"clips", "run", "report"},
}
# It uses the package as a script would: what a person types or drags is not for it.
STUDY_LEAVES = {"cli", "server", "project", "batch", "notebook"}


@dataclass(frozen=True)
class Import:
    """One import statement: where it stands and the module that it names."""

    path: Path
    line: int
    module: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: imports {self.module}"


def imports_of(path: Path, root: Path, wanted: Path | None = None) -> list[Import]:
    """Find the modules of a package that a file imports.

    `root` is the folder of the file's own package, `wanted` that of the other one; left out, it is the file's own.
    """
    wanted = root if wanted is None else wanted
    package = [root.name, *path.relative_to(root).parent.parts]
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            # "from retime.motion import rotation" names retime.motion.rotation where that is a module.
            found += [(node.lineno, _module_named(wanted, module, alias.name)) for alias in node.names]
    return [Import(path, line, module) for line, module in found if module.split(".")[0] == wanted.name]


def _module_named(root: Path, module: str, name: str) -> str:
    inner = root.joinpath(*module.split(".")[1:], name)
    return f"{module}.{name}" if inner.is_dir() or inner.with_suffix(".py").is_file() else module


def part_of(path: Path, root: Path) -> str:
    """Name the part that a file belongs to: its folder or, at the top, the module itself."""
    return path.relative_to(root).parts[0].removesuffix(".py")


def broken_rules(root: Path, may_import: dict[str, set[str]] = MAY_IMPORT, for_all: set[str] = FOR_ALL) -> list[str]:
    """List the imports that the rules forbid."""
    broken = []
    for path in sorted(root.rglob("*.py")):
        part = part_of(path, root)
        if part == "__init__":
            continue
        if part not in may_import:
            broken.append(f"{path}: {part} is a new part; say in {Path(__file__).name} what it may import")
            continue
        for found in imports_of(path, root):
            names = found.module.split(".")
            if len(names) == 1:
                broken.append(f"{found}: a part imports the package's table of contents")
            elif not {names[1], ".".join(names[1:3])} & ({part} | for_all | may_import[part]):
                broken.append(f"{found}: {part} may import {', '.join(sorted(for_all | may_import[part]))} only")
    return broken


def files_in_circles(root: Path) -> list[str]:
    """List the files that import each other in a circle (and those on a way from one circle to another)."""
    leads_to = {path: {found for found, _ in _targets(path, root)} for path in root.rglob("*.py")}
    while True:
        # A file that imports nothing that is left, or that nothing left imports, is in no circle.
        imported = set().union(*leads_to.values())
        loose = {path for path, targets in leads_to.items() if not targets or path not in imported}
        if not loose:
            break
        leads_to = {path: targets - loose for path, targets in leads_to.items() if path not in loose}
    return sorted(path.relative_to(root).as_posix() for path in leads_to)


def _targets(path: Path, root: Path) -> list[tuple[Path, Import]]:
    """Find the files of the package that a file imports, but for the table of contents."""
    found = []
    for one in imports_of(path, root):
        inner = root.joinpath(*one.module.split(".")[1:])
        target = inner / "__init__.py" if inner.is_dir() else inner.with_suffix(".py")
        if target.is_file() and target not in (path, root / "__init__.py"):
            found.append((target, one))
    return found


def reached_from(start: Path, root: Path) -> dict[Path, list[Import]]:
    """Find every file of the package that importing `start` can load, each with the imports that lead to it."""
    chains: dict[Path, list[Import]] = {start: []}
    waiting = [start]
    while waiting:
        path = waiting.pop()
        for target, found in _targets(path, root):
            if target not in chains:
                chains[target] = [*chains[path], found]
                waiting.append(target)
    return chains


def test_a_part_imports_only_what_stands_below_it() -> None:
    broken = broken_rules(PACKAGE)
    assert not broken, "\n".join(broken)


def test_of_the_warp_only_its_value_opens_files() -> None:
    opening = {
        path.name
        for path in (PACKAGE / "warp").glob("*.py")
        if any(found.module == "retime.files" for found in imports_of(path, PACKAGE))
    }
    assert opening == {"curve.py"}


def test_a_room_of_the_study_imports_only_what_stands_below_it() -> None:
    broken = broken_rules(STUDY, STUDY_MAY_IMPORT, STUDY_FOR_ALL)
    assert not broken, "\n".join(broken)


def test_the_package_knows_nothing_of_the_study_and_the_study_nothing_of_those_who_type_and_drag() -> None:
    upward = [link for path in PACKAGE.rglob("*.py") for link in imports_of(path, PACKAGE, STUDY)]
    assert not upward, "\n".join(map(str, upward))
    used = [link for path in STUDY.rglob("*.py") for link in imports_of(path, STUDY, PACKAGE)]
    assert any(link.module.startswith("retime.warp.") for link in used)
    beyond = [str(link) for link in used if STUDY_LEAVES & set(link.module.split(".")[1:2])]
    assert not beyond, "\n".join(beyond)


def test_a_format_of_curves_knows_nothing_of_the_others() -> None:
    curves = PACKAGE / "formats" / "curves"
    rooms = {f"retime.formats.curves.{path.parent.name}" for path in curves.glob("*/__init__.py")}
    assert len(rooms) > 2
    beyond = [
        str(found)
        for path in curves.rglob("*.py")
        for found in imports_of(path, PACKAGE)
        for room in rooms
        if f"{found.module}.".startswith(f"{room}.") and path.parent != curves / room.split(".")[-1]
    ]
    assert not beyond, "\n".join(beyond)


def test_no_file_imports_in_a_circle() -> None:
    # What is imported for types alone ties two files as closely as the rest.
    assert files_in_circles(PACKAGE) == []


def test_a_circle_is_found_with_all_of_its_files(tmp_path) -> None:
    root = tmp_path / "retime"
    (root / "warp").mkdir(parents=True)
    codes = {
        "a": "from retime.warp import b\n",
        "b": "def f():\n    from retime.warp.c import g\n",
        "c": "import os\nfrom retime.warp.a import h\n",
        "into": "from retime.warp.a import h\n",
        "alone": "import os\n",
    }
    for name, code in codes.items():
        (root / "warp" / f"{name}.py").write_text(code, encoding="utf-8")
    assert files_in_circles(root) == ["warp/a.py", "warp/b.py", "warp/c.py"]


BLENDER = ROOT / "blender"
# Blender has NumPy and no other package that retime may need.
BLENDER_LEAVES = {"cli", "server", "batch", "media", "notebook", "__main__"}
# The only files that are told what Blender itself is; the others are handed its objects.
KNOW_BLENDER = {"settings.py", "operators.py", "panels.py"}


def test_the_blender_extension_sits_on_top_and_few_of_its_files_know_blender() -> None:
    upward = [link for path in PACKAGE.rglob("*.py") for link in imports_of(path, PACKAGE, BLENDER)]
    assert not upward, "\n".join(map(str, upward))
    used = [link for path in BLENDER.glob("*.py") for link in imports_of(path, BLENDER, PACKAGE)]
    assert any(link.module.startswith("retime.warp.") for link in used)
    beyond = [str(link) for link in used if BLENDER_LEAVES & set(link.module.split(".")[1:2])]
    assert not beyond, "\n".join(beyond)
    knowing = {
        path.name for path in BLENDER.glob("*.py") if re.search(r"^\s*(import|from) bpy\b", path.read_text(), re.M)
    }
    assert knowing == KNOW_BLENDER


# What works where NumPy is, and nothing else (tests/core_alone.py uses it there); and what of it can do more.
CORE = {*FOR_ALL, "motion", "warp", "search", "kernels", "files", "formats", "hosts", "data", "project"}
MORE = {("search/explain.py", "pandas"), ("formats/parquet.py", "pyarrow")}
# What of USD runs here; the rest runs in a process of its own, which pxr may bring down.
NO_PXR = {"__init__", "decoder", "exchange", "format", "motion", "package"}
USD_ROOM = PACKAGE / "formats" / "curves" / "usd"
MORE |= {(path.relative_to(PACKAGE).as_posix(), "pxr") for path in USD_ROOM.glob("*.py") if path.stem not in NO_PXR}


def test_the_core_needs_no_package_but_numpy() -> None:
    foreign = set()
    for path in PACKAGE.rglob("*.py"):
        if part_of(path, PACKAGE) in CORE:
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                if isinstance(node, ast.ImportFrom) and not node.level:
                    names = [node.module or ""]
                foreign |= {(path.relative_to(PACKAGE).as_posix(), name.split(".")[0]) for name in names}
    known = {*sys.stdlib_module_names, "numpy", "retime"}
    assert {(path, name) for path, name in foreign if name not in known} == MORE


def test_warping_a_video_needs_only_the_warp_curve() -> None:
    others = {PACKAGE / "motion", PACKAGE / "formats", PACKAGE / "kernels"}
    others |= {PACKAGE / "search"}
    for path, chain in reached_from(PACKAGE / "warp" / "curve.py", PACKAGE).items():
        forbidden = others & {path, *path.parents}
        assert not forbidden, "warp.curve must not need this:\n" + "\n".join(str(link) for link in chain)


def test_importing_the_warp_curve_loads_nothing_else_of_the_package() -> None:
    # The packages around it (their __init__.py) are loaded too, and could bring in everything.
    code = "import sys, retime.warp.curve; print(*sorted(m for m in sys.modules if m.startswith('retime')))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = run.stdout.split()
    assert "retime.warp.curve" in loaded
    assert [name for name in loaded if re.match(r"retime\.(motion|formats|kernels)\b", name)] == []


@pytest.mark.parametrize(
    ("place", "code", "module"),
    [
        ("motion/pose.py", "import os\nimport retime.warp.curve\n", "retime.warp.curve"),
        ("motion/pose.py", "import os\nfrom retime.formats import read\n", "retime.formats"),
        ("motion/pose.py", "import os\nfrom ..warp import curve\n", "retime.warp"),
        ("warp/path.py", "def f():\n    from retime import formats\n", "retime.formats"),
        ("cli/inner/main.py", "import os\nfrom ...notebook import edit\n", "retime.notebook"),
        ("server/app.py", "import os\nfrom retime.cli.terminal import say\n", "retime.cli.terminal"),
        ("formats/a.py", "import os\nfrom retime.search.guided import guided_warp\n", "retime.search.guided"),
        ("errors.py", "import os\nfrom retime.motion.rate import parse_rate\n", "retime.motion.rate"),
        ("warp/path.py", "import os\nimport retime\n", "retime"),
    ],
)
def test_a_forbidden_import_is_named_with_its_file_and_line(tmp_path, place, code, module) -> None:
    root = tmp_path / "retime"
    for folder in ("cli", "formats", "server", "warp"):
        (root / folder).mkdir(parents=True)
    path = root / place
    path.parent.mkdir(parents=True, exist_ok=True)
    (root / "warp" / "guided.py").touch()
    path.write_text(code, encoding="utf-8")
    (message,) = broken_rules(root)
    assert message.startswith(f"{path}:2: imports {module}: ")


@pytest.mark.parametrize(
    ("place", "code"),
    [
        ("warp/path.py", "from retime.motion.motion import Motion\nfrom retime.errors import OptionError\n"),
        ("warp/path.py", "from . import curve\nimport numpy as np\n"),
        ("formats/a.py", "from retime.warp.curve import Warp\n"),
        ("__init__.py", "from retime.cli import main\n"),
    ],
)
def test_an_allowed_import_passes(tmp_path, place, code) -> None:
    path = tmp_path / "retime" / place
    path.parent.mkdir(parents=True)
    path.write_text(code, encoding="utf-8")
    assert broken_rules(tmp_path / "retime") == []
