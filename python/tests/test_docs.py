"""Every program and command of docs/PYTHON.md and every notebook runs, and the README shows the
same five lines. ``SUREFOOT_BLESS=1`` writes what the notebooks print into them."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import surefoot

PROGRAM = os.environ.get("SUREFOOT_PROGRAM") or shutil.which("surefoot")
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(path: Path) -> list[str]:
    """The Python programs of a page, in their order."""
    return BLOCK.findall(path.read_text())


def test_the_page_runs_from_top_to_bottom(repository: Path, tmp_path: Path) -> None:
    program = "\n".join(blocks(repository / "docs/PYTHON.md"))
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.count("left [") > 3 and "goal_invalid" in run.stdout


def test_all_pages_show_the_same_five_lines(repository: Path) -> None:
    five = blocks(repository / "docs/PYTHON.md")[0]
    assert len([line for line in five.splitlines() if line]) <= 5
    assert five in blocks(repository / "README.md")
    assert five in blocks(repository / "python/README.md")


def test_the_example_makes_a_data_set(repository: Path, tmp_path: Path) -> None:
    if not all(importlib.util.find_spec(name) for name in ("ray", "pyarrow")):
        pytest.skip("needs ray and pyarrow")
    command = [sys.executable, str(repository / "python/examples/data_set.py"), "--walks", "4"]
    run = subprocess.run(
        [*command, "--workers", "2"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0 and run.stdout.startswith("4 walks: {'accepted': 4}"), run.stderr
    assert len(list((tmp_path / "data_set/plans").glob("*.json"))) == 4
    assert (tmp_path / "data_set/statistics.html").is_file()


def run(command: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """A command of a page, with this interpreter in place of python."""
    command = [sys.executable if word == "python" else word for word in command]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def commands(page: Path) -> list[list[str]]:
    """The commands of a page that run a module of the package, as words."""
    found = re.findall(r"^python (-m surefoot[^#\n]*)", page.read_text(), re.MULTILINE)
    return [["python", *line.split()] for line in found]


def test_the_commands_of_the_page_run(
    repository: Path, plan: surefoot.Plan, tmp_path: Path
) -> None:
    if not all(importlib.util.find_spec(name) for name in ("ray", "pyarrow", "rerun")):
        pytest.skip("needs ray, pyarrow and rerun-sdk")
    view, batch = commands(repository / "docs/PYTHON.md")
    plan.save(tmp_path / "walk.json")
    shown = run([*view, "--save", "walk.rrd"], tmp_path)
    assert shown.returncode == 0 and (tmp_path / "walk.rrd").stat().st_size, shown.stderr
    assert "1-100" in batch
    few = ["1-2" if word == "1-100" else word for word in batch]
    planned = run(few, tmp_path)
    assert planned.returncode == 0 and json.loads(planned.stdout)["walks"] == 4, planned.stderr
    for name in ("walks.parquet", "times.parquet", "statistics.html"):
        assert (tmp_path / "walks" / name).is_file()


def test_the_program_that_listens_runs(repository: Path, tmp_path: Path) -> None:
    if PROGRAM is None or importlib.util.find_spec("iceoryx2") is None:
        pytest.skip("needs iceoryx2 and the program; set SUREFOOT_PROGRAM")
    text = (repository / "docs/PYTHON.md").read_text()
    (shown,) = re.findall(r"^```python notest\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    name = f"test-docs-{os.getpid()}"
    assert '"walk-4711"' in shown
    listens = shown.replace('"walk-4711"', f'"{name}", wait=60.0')
    walking = subprocess.Popen(
        [PROGRAM, "walk", "ibeam_gap", "--quiet", "--instance", name, "--rate", "40"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    heard = run(["python", "-c", listens], tmp_path)
    assert walking.wait(timeout=120) == 0
    assert heard.returncode == 0 and heard.stdout.endswith("chunks were missed\n"), heard.stderr


def printed(cells: list[dict[str, Any]]) -> list[str]:
    """What each code cell of a notebook prints, in one namespace."""
    names: dict[str, Any] = {"__name__": "__main__"}
    texts = []
    for cell in cells:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec("".join(cell["source"]), names)
        texts.append(out.getvalue())
    return texts


@pytest.mark.parametrize("name", ["first_walk", "own_world", "without_a_plan"])
def test_a_notebook_prints_what_it_shows(
    repository: Path, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = repository / f"docs/notebooks/{name}.ipynb"
    notebook = json.loads(path.read_text())
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    monkeypatch.chdir(tmp_path)
    texts = printed(cells)
    assert sum(map(bool, texts)) >= 3
    if os.environ.get("SUREFOOT_BLESS"):
        for number, (cell, text) in enumerate(zip(cells, texts, strict=True), 1):
            cell["execution_count"] = number
            cell["outputs"] = [stream(text)] if text else []
        path.write_text(json.dumps(notebook, indent=1) + "\n")
    for cell, text in zip(cells, texts, strict=True):
        assert "".join(line for out in cell["outputs"] for line in out["text"]) == text


def stream(text: str) -> dict[str, Any]:
    """A cell's output on the standard output."""
    lines = text.splitlines(keepends=True)
    return {"name": "stdout", "output_type": "stream", "text": lines}
