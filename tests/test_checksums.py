"""A result that is not what its rule wrote is noticed where it is read, and by `ovman check`."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from ovman.cli import main
from ovman.doctor.results import PER_SCENE, Results, check
from ovman.records.visit import VisitManifest, seal
from ovman.settings.config import load
from ovman.workflow import checksums
from ovman.workflow.job import job
from ovman.workflow.journal import Journal
from tests.test_job import Named, rule

ROOT = Path(__file__).parents[1]
SETTINGS = load(ROOT / "config.yaml")
SCENES = SETTINGS.splits["main"].scenes
TRIALS, MAPS = "results/trials/FloorPlan1.jsonl", "results/maps/FloorPlan1.npz"
AGAIN = "make it again: snakemake --cores 2 --force -- "


@pytest.fixture(autouse=True)
def directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("OVMAN_WORKFLOW_PID", raising=False)
    return tmp_path


def make(output: str, content: str, *inputs: str, name: str = "trials") -> None:
    """What a job of the workflow does."""
    with job(rule(input=Named(enumerate(inputs)), output=Named(out=output))) as work:
        if Path(output).suffix:
            work.output("out").write_text(content)
        else:
            work.output("out").mkdir()
            (work.output("out") / "a.csv").write_text(content)
            (work.output("out") / "b.csv").write_text(content)


def found() -> list[str]:
    return [str(damage) for damage in checksums.damages(Path())]


DAMAGES = {
    "emptied": lambda path: path.write_bytes(b""),
    "shortened": lambda path: path.write_bytes(path.read_bytes()[:-4]),
    "a changed digit": lambda path: path.write_bytes(path.read_bytes().replace(b"1", b"7")),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_changed_input_stops_the_job_that_reads_it_with_one_line(damage):
    make(TRIALS, '{"x":1}\n{"x":2}\n')
    make(MAPS, "maps", TRIALS)
    assert found() == []
    damage(Path(TRIALS))
    line = f"{TRIALS}: has changed since the rule scenes wrote it; {AGAIN}{TRIALS}"
    with pytest.raises(SystemExit) as ended:
        make("results/walks/FloorPlan1.npz", "walks", TRIALS)
    assert ended.value.code == line and not Path("results/walks/FloorPlan1.npz").exists()
    assert found()[-1] == line


def test_what_was_made_again_with_the_same_bytes_makes_nothing_stale_and_other_bytes_do():
    make(TRIALS, "1")
    make(MAPS, "maps", TRIALS)
    make(TRIALS, "1")
    assert found() == []
    make(TRIALS, "2")
    assert found() == [f"{MAPS}: is stale, it was made from another {TRIALS}; {AGAIN}{MAPS}"]
    make(MAPS, "maps", TRIALS)
    assert found() == []
    Path(TRIALS).unlink()
    missing = f"{TRIALS}: is missing; {AGAIN}{TRIALS}"
    assert found() == [f"{MAPS}: is stale, it was made from another {TRIALS}; {AGAIN}{MAPS}", missing]


def test_a_folder_is_checked_file_by_file():
    make("results/tables", "1")
    (Path("results/tables") / ".snakemake_timestamp").touch()
    assert found() == []
    Path("results/tables/b.csv").write_text("2")
    assert found() == [f"results/tables: b.csv in it has changed since the rule scenes wrote it; {AGAIN}results/tables"]
    Path("results/tables/a.csv").unlink()
    assert found()[0].startswith("results/tables: a.csv in it is missing since the rule scenes wrote it")


def test_torn_checksums_are_named():
    make(TRIALS, "1")
    checksums.path_of(Path(TRIALS)).write_text('{"rule":')
    torn = f"{TRIALS}: its checksums in results/checksums/trials/FloorPlan1.jsonl.json are torn; {AGAIN}{TRIALS}"
    assert found() == [torn]
    make(TRIALS, "1")
    assert found() == []


def test_files_outside_the_results_are_the_users_own():
    Path("weights.bin").write_text("1")
    make(TRIALS, "1", "weights.bin", str(ROOT / "config.yaml"))
    Path("weights.bin").write_text("2")
    make("elsewhere/x.txt", "1")
    assert found() == [] and not list(Path("results/checksums").rglob("x.txt*"))


def results(directory: Path) -> None:
    """A small results/ for the default settings, whole."""
    for scene in SCENES:
        make(f"results/scenes/{scene}.json", "{}")
    lines = [json.dumps({"relation": relation}) for relation, count in SETTINGS.splits["main"].episodes for _ in range(count)]
    make("results/episodes/main.jsonl", "\n".join(lines) + "\n")
    make("results/tables", "1", "results/episodes/main.jsonl")
    journal = Journal(directory / "results/journal/trials/FloorPlan1.jsonl")
    for key in "ab":
        journal.write(key, {"x": 1})


def test_whole_results_are_whole(directory, capsys):
    results(directory)
    assert main(["check", "--config", str(ROOT / "config.yaml")]) == 0
    line = capsys.readouterr().out
    assert line.startswith("results: whole; not made: ") and "detections" in line and "scenes" not in line
    for folder, suffix in ({"visits": ".json"} | PER_SCENE).items():
        for scene in SCENES:
            made = VisitManifest(scene=scene, visits={}).to_line() if folder == "visits" else "{}"
            make(f"results/{folder}/{scene}{suffix}", made)
    assert main(["check", "--config", str(ROOT / "config.yaml")]) == 0
    assert capsys.readouterr().out == "results: whole\n"


def test_every_fault_is_one_line_and_the_exit_status_tells(directory, capsys):
    results(directory)
    journal = Path("results/journal/trials/FloorPlan1.jsonl")
    journal.write_bytes(journal.read_bytes().replace(b'"x":1', b'"x":2', 1))
    shutil.rmtree("results/checksums/scenes")
    Path("results/scenes/FloorPlan7.json").unlink()
    episodes = Path("results/episodes/main.jsonl")
    episodes.write_text("".join(episodes.read_text().splitlines(keepends=True)[1:]))
    assert main(["check", "--config", str(ROOT / "config.yaml")]) == 1
    *lines, last = capsys.readouterr().out.splitlines()
    assert last.partition(";")[0] == f"results: {len(lines)} faults"
    remedy = "raise splits.main.draws or lower splits.main.episodes, then `make tables`"
    expected = [
        "results/scenes/FloorPlan7.json: is missing; make it: snakemake --cores 2 -- results/scenes/FloorPlan7.json",
        f"results/episodes/main.jsonl: has changed since the rule scenes wrote it; {AGAIN}results/episodes/main.jsonl",
        f"results/tables: is stale, it was made from another results/episodes/main.jsonl; {AGAIN}results/tables",
        f"{journal}, line 1: its content does not match its digest; the next run of its job makes the unit again",
        f"results/episodes/main.jsonl: has fewer episodes than splits.main.episodes asks for (moved 32 of 33); {remedy}",
    ]
    assert lines[:5] == expected
    assert len(lines) == 5 + 19 and all("has no checksums in results/checksums/scenes/" in line for line in lines[5:])


def test_a_damaged_tour_is_named_with_a_command_that_snakemake_takes(directory):
    tour = directory / "results/visits/FloorPlan1/untouched"
    tour.mkdir(parents=True)
    for name in ("00_rgb.png", "visit.json"):
        (tour / name).write_text(name)
    manifest = VisitManifest(scene="FloorPlan1", visits={"untouched": seal(tour).content})
    (directory / "results/visits/FloorPlan1.json").write_text(manifest.to_line())
    there = Results(directory, SETTINGS)
    assert list(check(there)) == []
    (tour / "00_rgb.png").unlink()
    (line,) = check(there)
    assert line.startswith("results/visits/FloorPlan1/untouched/00_rgb.png: No such file or directory; record it again: ")
    assert line.endswith("snakemake --cores 2 --force results/visits/FloorPlan1.json")


def test_a_torn_split_and_no_results_are_one_line(directory):
    there = Results(directory, SETTINGS)
    assert list(check(there)) == [f"{directory}/results: is no folder; give the one that `make tables` wrote"]
    make("results/episodes/main.jsonl", '{"relation":"moved"}\n{"rel')
    assert list(check(there)) == [f"results/episodes/main.jsonl: is torn; {AGAIN}results/episodes/main.jsonl"]
