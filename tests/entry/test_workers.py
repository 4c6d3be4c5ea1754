"""`--workers`: however an evaluation was shared out, the same bytes are left."""

from __future__ import annotations

from ovman.settings import MAIN
from tests.entry.evaluations import DEPTH, SCENE, SECOND_SCENE, command


def test_two_workers_leave_the_bytes_of_one_process(tours, tmp_path):
    options = ["--arm", DEPTH, "--split", MAIN, "--scenes", SCENE, SECOND_SCENE, "--seeds", "0", "--cache", tours]
    for workers in ("1", "2"):
        assert command("eval", "--out", tmp_path / workers, "--workers", workers, *options) == 0
    for name in ("runs.jsonl", "summary.json", "manifest.json"):
        assert (tmp_path / "1" / name).read_bytes() == (tmp_path / "2" / name).read_bytes()
