"""A wrong setting stops the workflow with one line, before anything is touched."""

from __future__ import annotations

import pytest

from tests.workflow.conftest import ROOT, World

SNAKEMAKES = ("Using workflow specific profile", "Config file")
"""How the lines begin that Snakemake prints before it reads a Snakefile."""


@pytest.mark.parametrize(
    ("overlay", "line"),
    [
        ({"association": {"gama_m": 1.0}}, "overlay.yaml: association.gama_m is not a setting; did you mean gate_m?"),
        ({"tour": {"waypoints": "six"}}, 'overlay.yaml: tour.waypoints is "six"; it must be a valid integer (W, farthest-point'),
    ],
)
def test_a_wrong_setting_is_one_line(tmp_path, overlay, line):
    said = World(tmp_path).snakemake(overlay=overlay)
    assert said.returncode != 0
    lines = [text for text in said.stdout.splitlines() if not text.startswith(SNAKEMAKES)]
    assert len(lines) == 1 and lines[0].startswith(line)
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"tour: {waypoints: 3} # caf\xe9\n", ":1:27: is not UTF-8 text (byte 0xe9); save it as UTF-8"),
        (b"tour:\n\twaypoints: 3\n", r":2:1: found character '\t' that cannot start any token; indent with spaces"),
        (b"tour: {waypoints: 3", ":1:20: expected ',' or '}', but got '<stream end>'; mend the YAML there"),
        (b"", ": is empty; it must hold sections (benchmark:, camera:, ...), or be left out"),
        (None, ": No such file or directory; give the path of a file of settings (.yaml)"),
    ],
    ids=["Latin-1", "tab", "syntax", "empty", "missing"],
)
def test_an_overlay_that_snakemake_cannot_read_is_one_line(tmp_path, content, line):
    overlay = tmp_path / "mine.yaml"
    if content is not None:
        overlay.write_bytes(content)
    said = World(tmp_path).snakemake("--configfile", str(ROOT / "overlays" / "tiny.yaml"), str(overlay))
    assert said.returncode != 0
    assert [text for text in said.stdout.splitlines() if not text.startswith(SNAKEMAKES)] == [f"{overlay}{line}"]
    assert not (tmp_path / "results").exists()
