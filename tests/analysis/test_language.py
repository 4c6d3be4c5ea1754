"""Sentences asked of the two-visit agent: what is understood is what it answers, and what is not is a failure."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from ovman.analysis.language import answer, write_language
from ovman.evaluation.observations import ObservationStore, Perceived
from ovman.evaluation.predictions import predict
from ovman.language import RELATIONS, noun
from ovman.language.parser import ParseFailure
from ovman.language.vocabulary import nouns
from ovman.perception.clusters import Cluster
from ovman.perception.records import write_maps, write_nouns
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, AbstentionReason, Prediction
from ovman.records.record import lines
from ovman.records.visit import VisitPair
from tests.arms import BY_NAME, CONFIG
from tests.episodes import episode_record

SCENE = "FloorPlan1"
VISITS = VisitPair[str](first="before", second="after")
FEATURES = {"Chair": (1.0, 0.0, 0.0), "Sofa": (0.0, 1.0, 0.0)}
NOUNS = {phrase: np.array(feature) for category, feature in FEATURES.items() for phrase in nouns(category)}


def cluster(x: float, z: float, category: str, view: int) -> Cluster:
    return Cluster(np.array([x, z]), np.array(FEATURES[category]), np.array([[x, z]]), np.array([view]))


MAPS = {
    # A chair went from x = 0 to x = 5, one at x = 2 stayed; the sofa stands still.
    "before": (cluster(0, 0, "Chair", 0), cluster(2, 0, "Chair", 1), cluster(-4, 0, "Sofa", 2)),
    "after": (cluster(5, 0, "Chair", 3), cluster(2, 0, "Chair", 1), cluster(-4, 0, "Sofa", 2)),
}
ANSWERS = {"moved": 5.0, "former": 0.0, "moving": 5.0, "stable": 2.0, "appeared": 5.0, "removed": 0.0}
PERCEIVED = Perceived(MAPS, NOUNS)


def episode(relation: str, number: int = 0) -> Episode:
    return Episode.from_json(episode_record(relation, number, answer=(ANSWERS[relation], 0.0), visits=VISITS.to_json()))


@pytest.mark.parametrize("relation", RELATIONS)
def test_a_query_that_is_inferred_is_answered_as_the_arm_answers_it_supplied(relation, tmp_path):
    files = {"maps": tmp_path / f"{SCENE}.npz", "nouns": tmp_path / "nouns.npz"}
    write_maps(files["maps"], MAPS)
    write_nouns(files["nouns"], NOUNS)
    arm, given = BY_NAME["two_visits"], CONFIG
    supplied = predict(arm, episode(relation), given, ObservationStore(arm, given, 90.0, tmp_path, files))
    assert answer(noun("Chair"), relation, VISITS, PERCEIVED, CONFIG) == supplied
    assert supplied[0].x == ANSWERS[relation]


def held_out(tmp_path, **forms: str):
    path = tmp_path / "held_out.yaml"
    canonical = dict.fromkeys(RELATIONS, "go to where nobody knows the {noun}") | forms
    path.write_text(json.dumps({"origin": "made for a test", "forms": {key: [text] for key, text in canonical.items()}}))
    return path


def written(tmp_path, held_out_file):
    files = {name: tmp_path / name for name in ("main.jsonl", "two_visits.jsonl", f"{SCENE}.npz", "nouns.npz")}
    episodes = [episode(relation, number) for relation in RELATIONS for number in range(3)]
    files["main.jsonl"].write_text(lines(episodes))
    supplied = [Prediction.of(e.id, "two_visits", 0, *answer("chair", e.relation, VISITS, PERCEIVED, CONFIG)) for e in episodes]
    files["two_visits.jsonl"].write_text(lines(supplied))
    write_maps(files[f"{SCENE}.npz"], MAPS)
    write_nouns(files["nouns.npz"], NOUNS)
    output = tmp_path / "some" / "out"
    inputs = (files["main.jsonl"], files["two_visits.jsonl"], [files[f"{SCENE}.npz"]], files["nouns.npz"], held_out_file)
    write_language(*inputs, CONFIG, output, output / "language.csv")
    with (output / "language.csv").open(newline="") as file:
        return output, list(csv.DictReader(file))


def rate_of(rows, what, relation="all"):
    return next(row for row in rows if (row["what"], row["relation"]) == (what, relation))


def test_the_stage_counts_what_is_understood_and_fails_what_is_not(tmp_path):
    # MOVED is said rightly, STABLE as if it were REMOVED, nothing else is understood.
    forms = held_out(tmp_path, moved="go to the {noun} that was moved", stable="go to where the {noun} was that is gone")
    output, rows = written(tmp_path, forms)
    assert {what: int(rate_of(rows, what)["count"]) for what in ("object", "relation", "both")} == {
        "object": 6, "relation": 3, "both": 3,
    }  # fmt: skip
    assert [int(rate_of(rows, what)["count"]) for what in ("supplied", "relation_inferred", "inferred")] == [18, 3, 3]
    # What is read as another relation is answered by the one that is meant where that is supplied.
    assert int(rate_of(rows, "noun_inferred")["count"]) == 6
    whole = rate_of(rows, "inferred")
    assert (whole["wins"], whole["losses"]) == ("0", "15") and float(whole["p"]) == pytest.approx(2 * 0.5**15)
    read_as = {(row["relation"], row["read_as"]): int(row["count"]) for row in rows if row["what"] == "read_as"}
    assert read_as["stable", "removed"] == 3 and read_as["former", str(ParseFailure.NO_RELATION)] == 3
    assert sum(count for (relation, _), count in read_as.items() if relation == "all") == 18
    predictions = {p.episode: p.outcome for p in Prediction.read(output / "inferred.jsonl")}
    assert predictions[f"{SCENE}/former/0000"] == Abstention(AbstentionReason.NOT_PARSED)
    assert predictions[f"{SCENE}/stable/0000"].x == ANSWERS["removed"]
    for name in ("relation_inferred", "noun_inferred", "inferred"):
        records = Prediction.read(output / f"{name}.jsonl")
        assert {record.arm for record in records} == {f"{CONFIG.comparisons.agent}_{name}"}
        assert all((record.evidence is None) == isinstance(record.outcome, Abstention) for record in records)
    sentences = [json.loads(text) for text in (output / "sentences.jsonl").read_text().splitlines()]
    assert all(("parsed" in record) != ("failure" in record) for record in sentences) and len(sentences) == 18
