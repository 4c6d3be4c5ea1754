"""A wrong setting stops the workflow with one line, before anything is touched."""

from __future__ import annotations

import pytest

from tests.workflow.conftest import World


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
    lines = [text for text in said.stdout.splitlines() if not text.startswith(("Using workflow specific profile", "Config file"))]
    assert len(lines) == 1 and lines[0].startswith(line)
    assert not (tmp_path / "results").exists()
