"""What is missing for DualMap is one line with its remedy, and the page says the same."""

from __future__ import annotations

import subprocess
import sys

import pytest
from settings_of import settings_of

from ovman_released import dualmap_setup
from ovman_released.dualmap_setup import NEEDS, WEIGHTS, environment, lacks, missing_weights
from ovman_released.interpreter import Needs
from ovman_released.interpreter import lacks as lacks_of
from ovman_released.plugin import ReleasedDualmap
from ovman_released.settings import released_dualmap

COMMIT = released_dualmap(settings_of("dualmap")).commit


@pytest.fixture
def clone(tmp_path):
    """A repository with a commit, and that commit."""
    git = ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@b"]
    (tmp_path / "file.py").write_text("")
    for arguments in (["init", "--quiet"], ["add", "file.py"], ["commit", "--quiet", "--message", "a"]):
        subprocess.run([*git, *arguments], check=True)
    return tmp_path, subprocess.run([*git, "rev-parse", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()


def settings(root="", commit=COMMIT, python=sys.executable, device="cpu") -> ReleasedDualmap:
    given = {"root": str(root), "commit": commit, "python": str(python), "device": device}
    return released_dualmap(settings_of("dualmap", released_dualmap=given))


def test_without_a_clone_the_page_is_named():
    assert lacks(settings()) == "released_dualmap.root names no clone; packages/ovman-released/README.md says how to make one"


def test_a_clone_elsewhere_in_its_history_is_told_to_go_to_the_pin(clone):
    root, head = clone
    assert lacks(settings(root)) == f"the clone in {root} is at {head[:12]}; run: git -C {root} checkout {COMMIT}"


def test_then_the_interpreter_is_asked(clone):
    root, head = clone
    line = lacks(settings(root, head, root / "python"))
    assert line.startswith(f"released_dualmap.python is {root / 'python'}")
    line = lacks(settings(root, head))
    assert line.startswith("its environment lacks ") and "hydra-core" in line and sys.executable in line and "\n" not in line


@pytest.mark.parametrize("module", NEEDS.imported)
def test_a_module_that_is_there_and_does_not_work_is_missing(tmp_path, module):
    """As open3d is without the system's libraries, and rerun with a pyarrow that asks for a later NumPy."""
    (tmp_path / f"{module}.py").write_text("raise ImportError('it asks for\\nwhat is not there')")
    needs = Needs({module: module}, {}, {}, imported={module: NEEDS.imported[module]})
    line = lacks_of("released_dualmap", sys.executable, "cpu", needs, environment() | {"PYTHONPATH": str(tmp_path)})
    why = "ImportError: it asks for what is not there"
    assert line == f"{module} of its environment cannot be imported ({why}); {NEEDS.imported[module]}"
    assert set(NEEDS.imported) <= set(NEEDS.modules)


def test_then_the_weights(clone, monkeypatch):
    root, head = clone
    monkeypatch.setattr(dualmap_setup.interpreter, "lacks", lambda *arguments: None)
    for name in WEIGHTS:
        assert lacks(settings(root, head)).startswith(f"there is no {name} in {root}; in that folder run {sys.executable} -c ")
        (root / "model").mkdir(exist_ok=True)
        (root / name).write_bytes(b"")
    assert lacks(settings(root, head)) is None and missing_weights(root, "python") is None
