"""`--workers`: however an evaluation was shared out, the same bytes are left."""

from __future__ import annotations

from tests.entry.evaluations import DEPTH, SCENE, SECOND_SCENE, command
from tests.episodes import of_scene


def test_two_workers_leave_the_bytes_of_one_process(tours, tmp_path):
    chosen = [*of_scene(SCENE), *of_scene(SECOND_SCENE)[:1]]
    (tmp_path / "three.jsonl").write_text("".join(one.to_line() for one in chosen))
    options = ["--arm", DEPTH, "--episodes", tmp_path / "three.jsonl", "--seeds", "0", "--cache", tours]
    for workers in ("1", "2"):
        assert command("eval", "--out", tmp_path / workers, "--workers", workers, *options) == 0
    for name in ("runs.jsonl", "summary.json", "manifest.json"):
        assert (tmp_path / "1" / name).read_bytes() == (tmp_path / "2" / name).read_bytes()
