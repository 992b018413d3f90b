"""The types fit the extension module. Skipped without mypy."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy")


@pytest.mark.parametrize(
    "arguments",
    [
        ["mypy", "--strict", "-p", "surefoot"],
        ["mypy.stubtest", "surefoot._native"],
    ],
)
def test_mypy_finds_nothing(arguments: list[str], tmp_path: Path) -> None:
    config = tmp_path / "mypy.ini"
    text = "[mypy]\n[mypy-iceoryx2.*,rerun.*,ray.*,pyarrow.*]\nignore_missing_imports = True\n"
    text += "[mypy-surefoot._messages]\nignore_errors = True\n"
    config.write_text(text)
    option = "--mypy-config-file" if "stubtest" in arguments[0] else "--config-file"
    command = [sys.executable, "-m", *arguments, option, str(config)]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
