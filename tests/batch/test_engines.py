"""The examples of other engines run, each where its package can be had; none of them is part of an extra."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import retime

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples" / "engines"
PACKAGES = {
    "airflow": "airflow",
    "datasets": "datasets",
    "kubernetes": "dask_kubernetes",
    "ray": "ray",
    "slurm": "dask_jobqueue",
    "spark": "pyspark",
}
TOLD = [("a.bvh", "done", "32"), ("b.bvh", "done", "32"), ("bad.bvh", "failed", "0")]


def needs(engine: str) -> pytest.MarkDecorator:
    package = PACKAGES[engine]
    missing = importlib.util.find_spec(package) is None
    return pytest.mark.skipif(missing, reason=f"{package} is not installed (pip install it to run this example)")


def python(engine: str, *arguments: str, cwd: Path, **more: str) -> str:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path)), **more}
    command = [sys.executable, str(EXAMPLES / f"with_{engine}.py"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=cwd, env=environment, timeout=600)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def clips(tmp_path: Path) -> Path:
    folder = tmp_path / "clips"
    folder.mkdir()
    for number, name in enumerate("ab"):
        retime.write(retime.sample()[40 * number : 40 * number + 40], folder / f"{name}.bvh")
    (folder / "bad.bvh").write_text("HIERARCHY")
    return folder


def check(said: str, clips: Path, out: Path) -> None:
    assert re.findall(r"^(\w+\.bvh) (\w+) (\d+)", said, re.MULTILINE) == TOLD
    assert "expected ROOT" in said
    alone = retime.batch.run(clips, out.with_name("alone"), {"length": "80%"}, workers=0)
    assert alone.counts == {"done": 2, "kept": 0, "failed": 1}
    assert sorted(path.name for path in out.glob("*.bvh")) == ["a.bvh", "b.bvh"]
    for path in out.glob("*.bvh"):
        assert path.read_bytes() == (out.with_name("alone") / path.name).read_bytes()


def test_every_example_is_told_of() -> None:
    assert {path.stem.removeprefix("with_") for path in EXAMPLES.glob("*.py")} == PACKAGES.keys()
    page = (ROOT / "docs" / "batch.md").read_text(encoding="utf-8")
    for engine in PACKAGES:
        text = (EXAMPLES / f"with_{engine}.py").read_text(encoding="utf-8")
        (line,) = re.findall(rf"`([^`\n]+)`[^`\n]*`examples/engines/with_{engine}\.py`", page)
        assert line in text, f"docs/batch.md has {line!r}, and the example is another"


@pytest.mark.extras
@pytest.mark.parametrize("engine", [pytest.param(one, marks=needs(one)) for one in ("datasets", "ray", "spark")])
def test_an_engine_calls_the_function_of_one_clip(engine: str, clips: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    check(python(engine, str(clips), str(out), cwd=tmp_path, HF_HOME=str(tmp_path / "hf")), clips, out)


@pytest.mark.extras
@needs("airflow")
def test_airflow_has_a_task_for_each_clip(clips: Path, tmp_path: Path) -> None:
    dags, out = tmp_path / "airflow" / "dags", tmp_path / "out"
    dags.mkdir(parents=True)
    (dags / "library.py").write_bytes((EXAMPLES / "with_airflow.py").read_bytes())
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "AIRFLOW_HOME": str(dags.parent),
        "AIRFLOW__CORE__LOAD_EXAMPLES": "False",
        "CLIPS": str(clips),
        "OUT": str(out),
    }
    said = ""
    for words in ("db migrate", "dags reserialize", "dags test retime_library"):
        command = [sys.executable, "-m", "airflow", *words.split()]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, timeout=600)
        assert done.returncode == 0, done.stderr
        said = done.stdout
    check(said, clips, out)


@pytest.mark.extras
@needs("slurm")
def test_slurm_is_asked_for_workers(tmp_path: Path) -> None:
    script = python("slurm", "--show", cwd=tmp_path)
    assert script.startswith("#!/")
    assert {"#SBATCH --cpus-per-task=1", "#SBATCH --mem=4G", "#SBATCH -t 04:00:00"} <= set(script.splitlines())
    assert re.search(r"dask_worker tcp://\S+ .*--nthreads 1 ", script)


@pytest.mark.extras
@needs("kubernetes")
def test_kubernetes_is_asked_for_pods(tmp_path: Path) -> None:
    spec = json.loads(python("kubernetes", "an/image", cwd=tmp_path))
    assert spec["kind"] == "DaskCluster"
    assert spec["spec"]["worker"]["replicas"] == 16
    (worker,) = spec["spec"]["worker"]["spec"]["containers"]
    assert (worker["image"], worker["resources"]["limits"]) == ("an/image", {"cpu": "1", "memory": "4Gi"})
    assert worker["args"][:4] == ["dask", "worker", "--nthreads", "1"]
