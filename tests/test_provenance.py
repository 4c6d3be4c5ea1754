"""The digest of the code that a rule runs."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import ovman
from ovman import provenance

PACKAGE = Path(ovman.__file__).parent


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A module outside OVMAN that can be imported and edited."""
    path = tmp_path / "entrant_of_a_test.py"
    path.write_text('"""An agent."""\n\nfrom ovman.task import success\n\nSPEED = 1\n')
    monkeypatch.syspath_prepend(tmp_path)
    importlib.invalidate_caches()
    yield path
    sys.modules.pop(path.stem, None)


def digest(path: Path) -> str:
    provenance._digest_file.cache_clear()
    return provenance.digest_code(path.stem)


def test_prose_and_layout_do_not_count_and_code_does(module: Path) -> None:
    before = digest(module)
    module.write_text('"""Another text."""\n\n# A comment.\nfrom ovman.task import success\n\n\nSPEED  =  1\n')
    assert digest(module) == before
    module.write_text(module.read_text().replace("1", "2"))
    assert digest(module) != before


def test_every_process_gives_the_same_digest() -> None:
    program = "from ovman.provenance import digest_code; print(digest_code())"
    seeds = ({**os.environ, "PYTHONHASHSEED": seed} for seed in ("1", "2"))
    assert len({subprocess.check_output([sys.executable, "-c", program], env=one) for one in seeds}) == 1


def test_imports_count_however_indirect() -> None:
    of_certification = provenance._closure("ovman.generation.certification")
    assert PACKAGE / "records" / "record.py" in of_certification
    assert PACKAGE / "report" / "release.py" not in of_certification


def test_weights_count_that_lie_in_a_file_named_like_the_module() -> None:
    assert PACKAGE / "agents" / "noun_blind.json" in provenance._closure("ovman.agents.noun_blind")
    assert PACKAGE / "language" / "held_out.yaml" in provenance._closure("ovman.runner")


def test_the_generator_of_homes_counts_where_homes_are_drawn_and_not_where_they_are_loaded() -> None:
    generator = PACKAGE / "homes" / "generate.py"
    assert generator in provenance._closure("ovman.generation.scenes")
    assert generator not in provenance._closure("ovman.generation.certification")


def test_the_simulator_counts_though_it_is_a_process_of_its_own() -> None:
    files = {path.name for path in provenance._closure("ovman.generation.certification") if "ovman_engine" in path.parts}
    assert {"__main__.py", "engine.py"} <= files


def test_modules_of_ovman_that_an_agent_imports_count(module: Path) -> None:
    before = digest(module)
    module.write_text(module.read_text().replace("task import success", "navigation import grid"))
    assert digest(module) != before


def test_a_module_that_does_not_exist_is_named() -> None:
    with pytest.raises(ModuleNotFoundError, match=r"ovman\.no_module"):
        provenance.digest_code("ovman.no_module")
    with pytest.raises(ModuleNotFoundError, match="no_package"):
        provenance.digest_code("no_package.agent")
