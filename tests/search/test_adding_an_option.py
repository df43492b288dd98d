"""Adding an option takes the steps that CONTRIBUTING.md names, and no more: here they are followed in a copy."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from retime.search.options import OPTIONS

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "src/retime"

DECLARATION = """\
    Option(
        name="dummy_weight",
        kind="number",
        default=0.5,
        stage="solve",
        section="Control",
        metavar="D",
        help="How much a dummy weighs.",
        label="Dummy",
        hint="How much a dummy weighs in the search",
        panel="timing",
        unit="kg",
        least=0.0,
        slider=(2.0, 0.25),
    ),
"""
# What a person writes: where, before what, and what.
STEPS = (
    (f"{PACKAGE}/search/options.py", ")\n\nBY_NAME", DECLARATION),
    (f"{PACKAGE}/search/guided.py", ") -> GuidedWarp:", "    dummy_weight: float = 0.5,\n"),
    (f"{PACKAGE}/search/guided.py", "\n    Returns\n", "    dummy_weight : float\n        How much a dummy weighs.\n"),
    (f"{PACKAGE}/search/session.py", "from retime.errors import", "from retime.errors import OptionError\n"),
    (
        f"{PACKAGE}/search/session.py",
        "        request = self._request(keys, locks, chosen)\n        with",
        '        if (weight := chosen["dummy_weight"]) != 0.5:\n'
        '            raise OptionError(f"a dummy weighs {weight:g}", option="dummy_weight")\n',
    ),
)

# Runs in the copy, and prints what is there.
LOOK = """\
import inspect, json, sys
# What is installed for working on it would come before the copy.
sys.meta_path[:] = [finder for finder in sys.meta_path if "editable" not in type(finder).__module__]
sys.path[:0] = ["src", "."]
import retime
from click.testing import CliRunner
from retime.cli.main import main
from retime.errors import OptionError
from retime.project.document import Document
from retime.project.faults import fault_of
from retime.project.solve import DocumentSolver
from retime.project.dataclass_json import from_value
from retime.server.message_coding import read_message
from tests.search import test_options
from study.defaults import parted

retime.write(retime.sample().frames(0, 300), "clip.bvh")
document = {"clips": [{"path": "clip.bvh"}], "options": {"length": "80%", "dummy_weight": 2}}
edit = {"type": "edit", "revision": 2, "gesture": "", "done": True, "label": "", "document": document}
found = {"package": retime.__file__, "message": read_message(json.dumps(edit)).document.options}
test_options.test_guided_warp_has_every_option_with_its_default()
test_options.test_guided_warp_documents_every_option()
test_options.test_names_and_flags_are_unique()
found["parted"] = parted({"dummy_weight": 2, "score": "joint"})
run = CliRunner().invoke(main, ["warp", "--help"], terminal_width=200)
found["help"] = run.output
run = CliRunner().invoke(main, ["warp", "clip.bvh", "--length", "80%", "--dummy-weight", "1.5 kg", "-o", "out.bvh"])
found["command"] = run.output
run = CliRunner().invoke(main, ["warp", "clip.bvh", "--length", "80%", "--dummy-weight", "-1", "-o", "out.bvh"])
found["bounds"] = run.output
value = from_value(Document, document, "document")
try:
    DocumentSolver().solve(value)
except OptionError as error:
    found["solver"] = str(error)
    found["fault"] = fault_of(error, value, None).field
print(json.dumps(found))
"""


def _steps() -> list[str]:
    """Return the steps that CONTRIBUTING.md names."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = re.split(r"^## ", text.split("## An option of the search\n", 1)[1], maxsplit=1, flags=re.M)[0]
    return re.findall(r"^\d+\. (.*(?:\n   .*)*)", section, flags=re.M)


def test_the_steps_are_at_most_five_and_name_every_file_that_is_written_by_hand() -> None:
    steps = _steps()
    assert 0 < len(steps) <= 5
    named = re.findall(r"`(src/[\w/]+\.py)`", "\n".join(steps))
    assert sorted(named) == sorted({path for path, _, _ in STEPS})


@pytest.fixture(scope="module")
def copy(tmp_path_factory) -> Path:
    """Copy what is changed and what is made, and follow the steps there."""
    root = tmp_path_factory.mktemp("copy")
    for folder in (PACKAGE, "tools", "study", "tests/search", "tests/reference"):
        shutil.copytree(
            ROOT / folder, root / folder, ignore=shutil.ignore_patterns("page", "__pycache__", "kernels/*.so")
        )
    for path, before, text in STEPS:
        place = root / path
        code = place.read_text(encoding="utf-8")
        assert code.count(before) == 1, f"{path} has no one place before {before!r}"
        place.write_text(code.replace(before, text + before), encoding="utf-8")
    (root / "web" / "src").mkdir(parents=True)
    return root


def _run(copy: Path, *arguments: str) -> str:
    environment = {**os.environ, "RETIME_BACKEND": "numpy"}
    done = subprocess.run(
        [sys.executable, *arguments], cwd=copy, env=environment, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_steps_bring_an_option_everywhere(copy: Path) -> None:
    found = json.loads(_run(copy, "-c", LOOK).splitlines()[-1])
    assert Path(found["package"]).resolve().is_relative_to(copy.resolve())
    # The command line, its help and its bounds.
    assert re.search(r"--dummy-weight D\s+How much a dummy weighs\.\s+\[default: 0\.5 kg\]", found["help"])
    assert "a dummy weighs 1.5" in found["command"]
    assert "of at least 0" in found["bounds"]
    # The document, what the page sends, the solver and what it blames.
    assert found["message"] == {"length": "80%", "dummy_weight": 2.0}
    assert (found["solver"], found["fault"]) == ("a dummy weighs 2", "options.dummy_weight")
    assert found["parted"] == [{"score": "joint"}, {"dummy_weight": 2}]


@pytest.mark.parametrize(
    ("tool", "page", "says"),
    [
        ("make_messages.py", "messages.ts", "readonly dummy_weight?: number;"),
        ("make_options.py", "options.ts", 'name: "dummy_weight",'),
    ],
)
def test_the_tools_bring_it_to_the_page(copy: Path, tool, page, says) -> None:
    before = (ROOT / "web" / "src" / page).read_text(encoding="utf-8")
    assert says not in before
    run = (
        "import sys, runpy\n"
        'sys.meta_path[:] = [finder for finder in sys.meta_path if "editable" not in type(finder).__module__]\n'
        'sys.path.insert(0, "src")\n'
        f'runpy.run_path("tools/{tool}", run_name="__main__")'
    )
    _run(copy, "-c", run)
    made = (copy / "web" / "src" / page).read_text(encoding="utf-8")
    assert says in made
    # Nothing else changes by it.
    assert set(before.splitlines()) <= set(made.splitlines())


def test_the_document_and_the_page_name_no_option_by_hand() -> None:
    # Names of one word mean other things too.
    names = [option.name for option in OPTIONS if "_" in option.name]
    assert len(names) > 5
    said = [*names, *(option.hint for option in OPTIONS), *(option.usual for option in OPTIONS if " " in option.usual)]
    files = [*(ROOT / PACKAGE / "project").glob("*.py"), *(ROOT / "web" / "src" / "panels").rglob("*.ts")]
    files.append(ROOT / "web" / "src" / "document.ts")
    found = [
        f"{path.relative_to(ROOT)}: {text}"
        for path in files
        # What older programs wrote stays as it was.
        if path.name != "versions.py"
        for text in said
        if text in path.read_text(encoding="utf-8")
    ]
    assert found == []
