"""Which kernels NumPy adds with: the same in jobs of the workflow and in the command `ovman`, where every processor has them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ovman import cli
from ovman.kernels import ONE_KERNEL, runs_one_kernel

ROOT = Path(__file__).parents[1]


@pytest.fixture
def environment(monkeypatch):
    """The environment of this process, without what is tested."""
    environment = {name: value for name, value in os.environ.items() if name not in ONE_KERNEL}
    monkeypatch.setattr(os, "environ", environment)
    return environment


@pytest.mark.parametrize(
    ("text", "runs"),
    [
        ("processor\t: 0\nflags\t\t: fpu fma avx avx2 avx512f\n", True),
        ("flags\t: fma avx2\n\nflags\t: fma avx2\n", True),
        ("flags\t: fma avx2\n\nflags\t: fma avx\n", False),
        ("flags\t: avx2\n", False),
        ("Features\t: fp asimd\n", False),
        ("", False),
        (None, False),
    ],
)
def test_kernels_are_those_that_every_processor_has(tmp_path, text, runs):
    cpu_info = tmp_path / "cpuinfo"
    if text is not None:
        cpu_info.write_text(text, encoding="utf-8")
    assert runs_one_kernel(cpu_info) is runs


@pytest.mark.parametrize("runs", [True, False])
def test_the_command_adds_with_the_kernels_of_jobs(monkeypatch, environment, runs):
    monkeypatch.setattr("ovman.kernels.runs_one_kernel", lambda: runs)
    cli.main(["--version"])
    assert (environment.items() >= ONE_KERNEL.items()) is runs
    assert environment["OPENBLAS_NUM_THREADS"] == "1"


@pytest.mark.parametrize("module", ["ovman.cli", "stage"])
def test_numpy_is_not_loaded_before_the_kernels_are_chosen(module):
    """OpenBLAS and NumPy read the environment when they are loaded."""
    code = f"import sys; sys.path.append('workflow/scripts'); import {module}; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT).returncode == 0
