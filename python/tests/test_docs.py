"""Every program of docs/PYTHON.md runs, and the README shows the same five lines."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

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
