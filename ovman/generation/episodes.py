"""Stage `episodes`: judges the certification runs, releases the split, and counts what was rejected. Pure."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ovman.language import noun, sentence
from ovman.models.settings import Settings
from ovman.models.settings.benchmark import Success
from ovman.sim.recorded import MEASURED, judged
from ovman.task import Episode, Rejection, Relation, episode_lines
from ovman.task.record import read_records
from ovman.workflow import seeds

SCHEMA = "ovman-episode/1"
REJECTION_COLUMNS = ("relation", "stage", "reason", "count")
DRAWN, CERTIFIED, RELEASED = "drawn", "certified", "released"


class ShortSplitError(ValueError):
    """Fewer episodes were certified than benchmark.split asks for; one line with the counts and the remedies."""

    says_all = True


def rejection(verdict: Mapping[str, Any], runs: Sequence[Mapping[str, Any]], constants: Success) -> Rejection | None:
    """Why a trial is not certified; None if it is: admissible, feasible, and completed in every certification run."""
    if verdict["rejected"] is not None:
        return Rejection(verdict["rejected"])
    relation = Relation(verdict["relation"])
    feasible, *certified = (judged(r, relation, constants) for r in runs)
    if not feasible:
        return Rejection.FEASIBILITY_FAILED
    return None if all(certified) else Rejection.CERTIFICATION_FAILED


def episode(trial: Mapping[str, Any], runs: Sequence[Mapping[str, Any]], backend: str, constants: Success) -> dict[str, Any]:
    """The record of a certified trial."""
    candidate, measured = trial["candidate"], trial["measured"]
    relation = Relation(candidate["relation"])
    word = noun(candidate["category"])
    return {
        "schema": SCHEMA,
        "id": candidate["id"],
        "split": "main",
        "backend": backend,
        "scene": candidate["scene"],
        "relation": relation.value,
        "category": candidate["category"],
        "noun": word,
        "sentence": sentence(relation, word),
        "target": candidate["target"],
        "distractor": candidate["distractor"],
        "changes": [_change(trial, alteration) for alteration in candidate["first"] + candidate["second"]],
        "spawn": candidate["spawn"],
        "answer": measured["answer"],
        "nearest_navigable": measured["nearest_navigable"],
        "shortest_path_m": measured["shortest_path_m"],
        "instances_in_category": max(len(measured["world_1"]), len(measured["world_2"])),
        "world_1": measured["world_1"],
        "world_2": measured["world_2"],
        "visits": measured["visits"],
        "drift_m": measured["drift_m"],
        "certification": [
            {k: r[k] for k in ("run", "seed")} | {"success": judged(r, relation, constants)} | {k: r[k] for k in MEASURED}
            for r in runs
        ],
    }


def _change(trial: Mapping[str, Any], alteration: Mapping[str, Any]) -> dict[str, Any]:
    """What happened to an instance between the visits. Gone before the first visit is "enable": it is there in the second."""
    measured, instance = trial["measured"], alteration["instance"]
    kind = "enable" if trial["candidate"]["relation"] == Relation.APPEARED else alteration["kind"]
    path = measured["mover"]["path"] if kind == "motion" else None
    return {"instance": instance, "kind": kind, **measured["changed"][instance], "path": path}


def select(certified: Mapping[str, Sequence[str]], wanted: int, rng: Any) -> list[str]:
    """`wanted` of the certified ids by scene: one scene after another in random order, one id of each per round."""
    order = sorted(certified)
    queues = {scene: [sorted(certified[scene])[k] for k in rng.permutation(len(certified[scene]))] for scene in order}
    scenes = [order[k] for k in rng.permutation(len(order))]
    chosen: list[str] = []
    depth = 0
    while len(chosen) < wanted and any(len(q) > depth for q in queues.values()):
        chosen += [queues[scene][depth] for scene in scenes if len(queues[scene]) > depth][: wanted - len(chosen)]
        depth += 1
    return chosen


def audit(
    rejections: Mapping[str, Rejection | None], relation_of: Mapping[str, Relation], released: Iterable[str]
) -> list[dict[str, Any]]:
    """Counts per relation x stage x reason, with what was drawn, certified and released beside them."""
    released = set(released)
    rows = []
    for relation in Relation:
        ids = [k for k in rejections if relation_of[k] is relation]
        counts = Counter(r for k in ids if (r := rejections[k]) is not None)
        rows.append({"relation": relation.value, "stage": DRAWN, "reason": "", "count": len(ids)})
        rows += [
            {"relation": relation.value, "stage": r.stage.value, "reason": r.value, "count": counts[r]}
            for r in Rejection
            if counts[r]
        ]
        rows.append({"relation": relation.value, "stage": CERTIFIED, "reason": "", "count": len(ids) - counts.total()})
        rows.append({"relation": relation.value, "stage": RELEASED, "reason": "", "count": sum(k in released for k in ids)})
    return rows


def run(
    trials_files: Sequence[Path],
    admissible_files: Sequence[Path],
    certified_files: Sequence[Path],
    constants: Settings,
    episodes_out: Path,
    rejections_out: Path,
) -> None:
    """Write the released episodes and the audit of rejections.

    ShortSplitError where a relation has fewer certified episodes than the split asks for, unless the settings allow that.
    """
    success = constants.success
    trials = {t["candidate"]["id"]: t for t in _records(trials_files)}
    verdicts = {v["id"]: v for v in _records(admissible_files)}
    runs = {c["id"]: c["runs"] for c in _records(certified_files)}
    rejections = {k: rejection(verdicts[k], runs.get(k, ()), success) for k in trials}
    relation_of = {k: Relation(v["relation"]) for k, v in verdicts.items()}
    released: list[str] = []
    short: list[str] = []
    for relation in Relation:
        pool: dict[str, list[str]] = {}
        for k, against in rejections.items():
            if against is None and relation_of[k] is relation:
                pool.setdefault(trials[k]["candidate"]["scene"], []).append(k)
        wanted = getattr(constants.benchmark.split, relation.value)
        chosen = select(pool, wanted, seeds.generator(constants.benchmark.seed, "split", relation.value))
        certified = sum(map(len, pool.values()))
        print(f"{relation.value}: {len(chosen)} released of {certified} certified, {wanted} wanted", flush=True)
        if len(chosen) < wanted and not constants.benchmark.allow_short_split:
            short.append(f"{relation.value} {certified} of {wanted}")
        released += chosen
    if short:
        remedy = "raise candidates.draws, lower benchmark.split, or set benchmark.allow_short_split to true"
        raise ShortSplitError(f"benchmark.split asks for more episodes than were certified ({', '.join(short)}); {remedy}")
    order = {scene: i for i, scene in enumerate(constants.benchmark.scenes)}
    released.sort(key=lambda k: (order[trials[k]["candidate"]["scene"]], list(Relation).index(relation_of[k]), k))
    records = [episode(trials[k], runs[k], constants.benchmark.backend, success) for k in released]
    episodes_out.write_text(episode_lines([Episode.from_json(r, r["id"]) for r in records]))
    with rejections_out.open("w", newline="") as file:
        writer = csv.DictWriter(file, REJECTION_COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(audit(rejections, relation_of, released))


def _records(files: Sequence[Path]) -> list[dict[str, Any]]:
    return [record for file in files for record in read_records(file)]
