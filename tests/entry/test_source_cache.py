"""What one command found in the code's files, the next one knows."""

from __future__ import annotations

from pathlib import Path

from ovman.entry import source_cache
from ovman.workflow import provenance, sources


def test_what_one_command_found_the_next_need_not_find_again(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))

    def command() -> str:
        monkeypatch.setattr(provenance, "_memory", sources.Memory())
        source_cache.remembered()
        return provenance.digest(Path(source_cache.__file__))

    found = command()
    assert (tmp_path / "ovman" / source_cache.FILE).exists()
    monkeypatch.setattr(sources, "_parsed", None)
    assert command() == found
