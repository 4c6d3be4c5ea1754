"""The digest of a stage's code changes with what the stage runs, and with nothing else."""

from __future__ import annotations

import pytest

from ovman.workflow import provenance, sources
from ovman.workflow.stages import STAGES

ONE = '"""One."""\n\nfrom . import two\nfrom ..b import three as other\n\n\ndef f():\n    """Doc."""\n    return two\n'
FILES = {
    "workflow/scripts/stage.py": "from ovman.a.one import f\n\nf()\n",
    "ovman/__init__.py": '"""Package."""\n\n__version__ = "1"\n',
    "ovman/a/__init__.py": "",
    "ovman/a/one.py": ONE,
    "ovman/a/two.py": "def late():\n    import ovman.c.four\n\n    return ovman.c.four\n",
    "ovman/b/__init__.py": "from ovman.b.three import g\n",
    "ovman/b/three.py": "from ovman.settings.config import load\n\ng = 1\n",
    "ovman/c/__init__.py": "",
    "ovman/c/__main__.py": "from ovman.c import five\n",
    "ovman/c/four.py": "x = 1  # why\n",
    "ovman/c/five.py": "y = 1\n",
    "ovman/settings/config.py": "from ovman import unused\n",
    "ovman/unused.py": "z = 1\n",
}
RUN = sorted(set(FILES) - {"workflow/scripts/stage.py", "ovman/settings/config.py", "ovman/unused.py"})


@pytest.fixture
def root(tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def digest(root):
    return provenance.digest(root / "workflow/scripts/stage.py", root)


def test_all_that_is_imported_in_whatever_way_is_found_and_settings_are_not_followed(root):
    found = provenance.modules(root / "workflow/scripts/stage.py", root)
    assert sorted(str(path.relative_to(root)) for path in found.values()) == RUN


@pytest.mark.parametrize("name", [*RUN, "workflow/scripts/stage.py"])
def test_code_counts_wherever_it_is(root, name):
    before = digest(root)
    (root / name).write_text(FILES[name] + "\nmore = 1\n")
    assert digest(root) != before


@pytest.mark.parametrize("name", ["ovman/settings/config.py", "ovman/unused.py"])
def test_code_that_a_stage_does_not_run_does_not_count(root, name):
    before = digest(root)
    (root / name).write_text(FILES[name] + "\nmore = 1\n")
    assert digest(root) == before


def test_prose_layout_and_the_number_of_the_version_do_not_count(root):
    before = digest(root)
    one = root / "ovman/a/one.py"
    one.write_text(ONE.replace('"""One."""', '"""Another\n\ntext."""\n\n').replace('    """Doc."""\n', ""))
    (root / "ovman/c/four.py").write_text("# because\n\n\nx = (1)\n")
    (root / "ovman/__init__.py").write_text('__version__ = "2"\n')
    assert digest(root) == before
    one.write_text(one.read_text().replace("return two", "return other"))
    assert digest(root) != before


def test_a_module_that_moves_counts(root):
    before = digest(root)
    (root / "ovman/c/four.py").rename(root / "ovman/c/six.py")
    (root / "ovman/a/two.py").write_text(FILES["ovman/a/two.py"].replace("four", "six"))
    assert digest(root) != before


def test_what_one_process_found_in_a_file_the_next_one_need_not_find_again(root, tmp_path, monkeypatch):
    def process():
        monkeypatch.setattr(provenance, "_memory", sources.Memory())
        provenance.remember(kept)
        return digest(root)

    kept = tmp_path / "kept.json"
    found = process()
    assert kept.exists()
    with monkeypatch.context() as patch:
        patch.setattr(sources, "_parsed", None)
        assert process() == found
    (root / "ovman/c/five.py").write_text("y = 2\n")
    changed = process()
    assert changed != found
    (root / "ovman/c/five.py").write_text(FILES["ovman/c/five.py"])
    assert process() == found
    for spoiled in (b"", b'{"', b"[]", kept.read_bytes().replace(sources._reader().encode(), b"another")):
        kept.write_bytes(spoiled)
        assert process() == found
    monkeypatch.setattr(sources, "_reader", lambda: "another")
    monkeypatch.setattr(sources, "_parsed", lambda source: (str(len(source)), ()))
    assert process() != found, "another reader trusts no findings of this one"


@pytest.fixture
def elsewhere(tmp_path_factory, monkeypatch):
    """A package and a module of somebody else, where Python finds them."""
    place = tmp_path_factory.mktemp("elsewhere")
    files = {
        "theirs/__init__.py": "raise RuntimeError\n",
        "theirs/agent.py": "from ovman.a import two\nfrom . import part\nimport json\n\n\ndef f():\n    return two\n",
        "theirs/part.py": "x = 1\n",
        "theirs/other.py": "y = 1\n",
        "alone.py": "def f():\n    return 1\n",
    }
    for name, text in files.items():
        (place / name).parent.mkdir(exist_ok=True)
        (place / name).write_text(text)
    monkeypatch.syspath_prepend(str(place))
    return place


def test_of_somebody_elses_module_its_own_package_and_ovman_count_and_nothing_is_imported(root, elsewhere):
    def digest(name="theirs.agent"):
        return provenance._Sources(root).module_digest(name)

    before = digest()
    assert before is not None and digest("alone") not in (None, before)
    for name in ("theirs.nowhere", "nowhere", "nowhere.at_all"):
        assert digest(name) is None
    (elsewhere / "theirs" / "other.py").write_text("y = 2\n")
    (root / "ovman/a/one.py").write_text(FILES["ovman/a/one.py"] + "\nmore = 1\n")
    (elsewhere / "theirs" / "part.py").write_text("# why\nx = 1\n")
    assert digest() == before
    for path in (elsewhere / "theirs" / "part.py", root / "ovman/c/four.py", elsewhere / "theirs" / "agent.py"):
        path.write_text(path.read_text() + "\nmore = 1\n")
        assert digest() != before
        before = digest()


def test_what_a_source_defines():
    text = "import a.b\nfrom c import d as e\nx, y = 1, 2\nz: int = 3\n\n\nclass F: ...\n\n\ndef g(): ...\n"
    assert sources.defined(text.encode()) == {"a", "e", "x", "y", "z", "F", "g"}
    assert sources.defined(b"from a import *\n") is None
    assert sources.defined(b"try:\n    from a import b\nexcept ImportError:\n    b = None\n") is None


def test_every_stage_has_a_script_and_the_simulator_is_code_of_those_that_start_it():
    for stage in STAGES:
        assert provenance.script(stage).is_file()
        modules = provenance.modules(provenance.script(stage))
        assert "ovman.workflow.parameter" in modules and not provenance.BOUNDARY & set(modules)
        if stage in ("scenes", "trials", "certified", "rollouts"):
            assert {"ovman_engine.__main__", "ovman_engine.physics.physics", "ovman.sim.session"} <= set(modules)
        if stage in ("admissible", "episodes", "predictions", "scores", "metrics", "tables"):
            assert not any(name.startswith("ovman_engine") for name in modules)
