"""Trials and recorded tours through the real engine: manifests, damaged tours, and engines that are killed."""

from __future__ import annotations

import itertools
import random
import re
import shutil
import threading
from dataclasses import dataclass
from pathlib import Path

import pytest

from ovman.cache import Cache
from ovman.evaluation import tours
from ovman.generation import candidates, scenes, trials
from ovman.generation.release import episode
from ovman.records.record import lines
from ovman.records.task import Relation
from ovman.records.trial import Candidate, Trial
from ovman.records.visit import FILES, REMEDY, TourError, Visit, VisitFiles, VisitManifest, kept, tour_path
from ovman.sim import controller
from ovman.sim.session import DEATHS
from tests.arms import CONFIG
from tests.tour_zips import contents, rewrite

SCENE = "FloorPlan429"
DRAWN = (Relation.MOVED, Relation.REMOVED)


@dataclass(frozen=True)
class Recorded:
    """A results directory with the trials of a scene, and the tours of those trials as if they were episodes."""

    root: Path

    @property
    def visits(self) -> Path:
        return self.root / "results" / "visits"

    def trials(self) -> tuple[Trial, ...]:
        return Trial.read(self.root / "trials.jsonl")

    def run(self) -> tuple[bytes, VisitManifest]:
        """Measure the candidates and record their tours: the trials, and the manifest."""
        output, manifest = self.root / "trials.jsonl", self.visits / "main.jsonl"
        trials.run(self.root / "scenes.jsonl", self.root / "candidates.jsonl", CONFIG, output, Cache(self.root / "cache"))
        (self.root / "episodes.jsonl").write_text(lines(episode(trial, (), CONFIG) for trial in self.trials()))
        tours.run(self.root / "episodes.jsonl", CONFIG, manifest, self.visits)
        return output.read_bytes(), VisitManifest.read(manifest)[0]

    def pictures(self) -> dict[str, int]:
        """When each file of the tours was written."""
        return {str(path): path.stat().st_mtime_ns for path in (self.visits / SCENE).rglob("*.*")}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    root = tmp_path_factory.mktemp("trials")
    recorded = Recorded(root)
    recorded.visits.mkdir(parents=True)
    scenes.run([SCENE], CONFIG, root / "scenes.jsonl", Cache(root / "cache"))
    candidates.run("main", root / "scenes.jsonl", CONFIG, root / "candidates.jsonl")
    drawn: dict[Relation, Candidate] = {}
    for candidate in Candidate.read(root / "candidates.jsonl"):
        if candidate.refused is None:
            drawn.setdefault(candidate.relation, candidate)
    (root / "candidates.jsonl").write_text(lines(drawn[relation] for relation in DRAWN))
    return recorded, *recorded.run()


@pytest.fixture
def copy(made, tmp_path):
    """A copy to damage."""
    shutil.copytree(made[0].root, tmp_path / "copy")
    return Recorded(tmp_path / "copy")


def test_the_manifest_has_a_digest_of_every_tour(made):
    recorded, _, manifest = made
    visits = [trial.measured.visits for trial in recorded.trials()]
    named = {name for each in visits for name in (each.first, each.second)}
    assert manifest.scene == SCENE and set(manifest.visits) == named and len(named) >= 2
    for name, digest in manifest.visits.items():
        tour = manifest.tour(recorded.visits, name)
        files = VisitFiles.load(tour)
        assert files.content == digest and kept(tour, files.key) and not kept(tour, "another")
        assert {*files.sha256, FILES} == {*contents(tour)}
    assert len(set(manifest.visits.values())) == len(named)


def test_what_is_kept_and_whole_is_not_recorded_again(made, monkeypatch):
    recorded, text, manifest = made
    before = recorded.pictures()
    monkeypatch.setattr(controller, "start", lambda *arguments: pytest.fail("a simulator was started"))
    assert recorded.run() == (text, manifest)
    assert recorded.pictures() == before


def test_damaged_tours_are_named_and_recorded_again(made, copy, capsys):
    _, text, manifest = made
    lost, other, torn = (tour_path(copy.visits / SCENE, name) for name in list(manifest.visits)[:3])
    rewrite(lost, {"03_rgb.png": None}, sealed=False)
    rewrite(other, {"02_depth.png": contents(other)["01_depth.png"]}, sealed=False)
    torn.write_bytes(torn.read_bytes()[:-500])
    before = copy.pictures()
    assert copy.run() == (text, manifest)
    said = capsys.readouterr().out
    for file, what in ((lost, "03_rgb.png"), (other, "02_depth.png"), (torn, "torn")):
        assert re.search(rf"^{re.escape(str(file))}: .*{what}.*{re.escape(REMEDY)}$", said, re.MULTILINE)
    assert {Path(path) for path, written in copy.pictures().items() if before.get(path) != written} == {lost, other, torn}


def test_readers_refuse_another_recording_than_the_manifests(made, copy):
    _, _, manifest = made
    other = next(name for name in manifest.visits if name != "untouched")
    shutil.copy(tour_path(copy.visits / SCENE, other), tour_path(copy.visits / SCENE, "untouched"))
    with pytest.raises(TourError, match="untouched.zip: another recording than the manifest's"):
        manifest.tour(copy.visits, "untouched")
    with pytest.raises(TourError, match="never.zip: not in the manifest"):
        manifest.tour(copy.visits, "never")


def test_trials_and_visits_say_the_same(made):
    """A trial looks at masks alone; the recorded tour has the same."""
    recorded, _, _ = made
    for trial in recorded.trials():
        for which in ("first", "second"):
            visit = Visit.load(tour_path(recorded.visits / SCENE, trial.measured.visits[which]))
            assert visit.sightings(trial.candidate.category) == trial.measured.sightings[which]


def test_both_stages_survive_their_engines(made, tmp_path, monkeypatch):
    """Engines are killed some steps after their start; what the stages write is what they would have written."""
    again, started, rng, begin = Recorded(tmp_path), [], random.Random(0), controller.start
    doomed = {*range(1, DEATHS), DEATHS + 1}  # while trials are measured, and while tours are recorded
    again.visits.mkdir(parents=True)
    for name in ("scenes.jsonl", "candidates.jsonl"):
        shutil.copy(made[0].root / name, tmp_path)

    def start_doomed(*arguments):
        engine = begin(*arguments)
        process, step, steps, last = engine.server.unity_proc, engine.step, itertools.count(1), rng.randint(2, 12)
        started.append(process)

        def step_or_die(*arguments, **named):
            if next(steps) == last:
                threading.Timer(rng.uniform(0.0, 0.005), process.kill).start()
            return step(*arguments, **named)

        if len(started) in doomed:
            engine.step = step_or_die
        return engine

    monkeypatch.setattr(controller, "start", start_doomed)
    assert again.run() == made[1:]
    assert len(started) == 2 + len(doomed) and all(process.poll() is not None for process in started)
    assert not list(tmp_path.rglob("*.partial"))
