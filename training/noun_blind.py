"""Fit ovman/agents/noun_blind.json, the weights of the control noun_blind: `python -m training.noun_blind SPLIT [RESULTS]`.

SPLIT is a split for development whose tours are recorded: `snakemake --cores 2 -- results/segments/SPLIT`. The model is a
conditional logit over the candidates of each query: weights that all relations share, and a deviation of each relation, both with
a Gaussian prior.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.optimize import minimize
from scipy.special import logsumexp

from ovman import seeds
from ovman.agents.interface import Relation
from ovman.agents.noun_blind import FEATURES, WEIGHTS, list_candidates
from ovman.analysis.outcomes import count_alike
from ovman.evaluation.context import EpisodeContext, agent_settings
from ovman.evaluation.observations import NOUNS, store_opener
from ovman.records.episode import Episode
from ovman.settings import Need
from ovman.settings.config import load
from ovman.settings.settings import arm_job, settings_of_arm
from ovman.settings.settings_files import with_parts

ARM = "noun_blind"
PRIORS = (1.0, 0.5, 0.2, 0.1)
"""Standard deviations of the prior, per standard deviation of a feature. The one that does best on scenes left out is taken."""
Asked = tuple[int, np.ndarray, np.ndarray]
"""Number of the relation, features (N, F) of the candidates, and which of them (N,) answer the query."""


def main() -> None:
    """Fit, print how well the weights do on the split itself and on scenes left out, and write them."""
    split, results = sys.argv[1], Path(sys.argv[2] if len(sys.argv) > 2 else "results")
    episodes = Episode.load(results / "episodes" / f"{split}.jsonl")
    asked = list(map(ask, episodes, open_contexts(episodes, split, results)))
    rows = np.concatenate([features for _, features, _ in asked])
    mean, scale = rows.mean(axis=0), np.maximum(rows.std(axis=0), 1e-6)
    asked = [(relation, (features - mean) / scale, right) for relation, features, right in asked]
    scenes = [episode.scene for episode in episodes]
    prior = max(PRIORS, key=lambda prior: sum(choose_apart(asked, scenes, prior)))
    weights = fit(asked, prior)
    outcomes = pd.DataFrame(
        {
            "relation": [episode.relation.value for episode in episodes],
            "queries": 1,
            "right piece found": [right.any() for _, _, right in asked],
            "fitted": [choose(one, weights) for one in asked],
            "other scenes": choose_apart(asked, scenes, prior),
            "1/m": [1 / alike for alike in count_alike(episodes).values()],
        }
    )
    of = outcomes.assign(relation="all"), outcomes
    how = dict.fromkeys(outcomes.columns[1:], "mean") | {"queries": "sum"}
    print(pd.concat(of).groupby("relation", sort=False).agg(how).round(3).to_string())
    written = {
        "split": split,
        "queries": len(asked),
        "prior": prior,
        "features": list(FEATURES),
        "mean": np.round(mean, 4).tolist(),
        "scale": np.round(scale, 4).tolist(),
        "weights": {str(relation): np.round(weights[k], 4).tolist() for k, relation in enumerate(Relation)},
    }
    WEIGHTS.write_text(json.dumps(written, separators=(",", ":")) + "\n", encoding="utf-8")


def open_contexts(episodes: list[Episode], split: str, results: Path) -> list[EpisodeContext]:
    """Return the contexts in which the arm answers episodes."""
    config = load(with_parts(Path(__file__).parents[1] / "config.yaml")[0])
    arm, settings = arm_job(config, ARM), settings_of_arm(config, ARM)
    perceived = {Need.SEGMENTS: results / "segments" / split, NOUNS: results / "nouns.npz"}
    open_store = store_opener(arm, settings, results / "visits", perceived)
    return [
        EpisodeContext(
            rng=seeds.generator(episode.provenance.seed, "training", episode.id),
            run=0,
            settings=agent_settings(episode, settings),
            episode=episode,
            arm=arm,
            store=open_store(episode.scene, episode.protocol.camera.field_of_view_deg),
        )
        for episode in episodes
    ]


def ask(episode: Episode, context: EpisodeContext) -> Asked:
    """Return the candidates of an episode's query, and which of them succeed on the static gate."""
    found = list_candidates(episode.relation, context)
    near = np.linalg.norm(found.places - np.array(episode.answer), axis=1) <= episode.protocol.success.radius_m
    return list(Relation).index(episode.relation), found.features, near


def fit(asked: list[Asked], prior: float) -> np.ndarray:
    """Return the weights (relations, F) that make right candidates most probable. Queries without one say nothing."""
    useful = [one for one in asked if one[2].any() and not one[2].all()]
    shape = len(Relation) + 1, asked[0][1].shape[1]

    def loss(flat: np.ndarray) -> tuple[float, np.ndarray]:
        shared = flat.reshape(shape)
        value, slope = float((shared**2).sum()) / (2 * prior**2), shared / prior**2
        for relation, features, right in useful:
            score = features @ (shared[-1] + shared[relation])
            chance, among = np.exp(score - logsumexp(score)), np.zeros(len(score))
            among[right] = np.exp(score[right] - logsumexp(score[right]))
            value += float(logsumexp(score) - logsumexp(score[right]))
            change = (chance - among) @ features
            slope[-1] += change
            slope[relation] += change
        return value, slope.ravel()

    found = minimize(loss, np.zeros(shape).ravel(), jac=True, method="L-BFGS-B").x.reshape(shape)
    weights: np.ndarray = found[:-1] + found[-1]
    return weights


def choose_apart(asked: list[Asked], scenes: list[str], prior: float) -> list[bool]:
    """Return whether each query is answered by weights that were fitted on the other scenes."""
    of_others = {}
    for scene in dict.fromkeys(scenes):
        of_others[scene] = fit([one for one, other in zip(asked, scenes, strict=True) if other != scene], prior)
    return [choose(one, of_others[scene]) for one, scene in zip(asked, scenes, strict=True)]


def choose(one: Asked, weights: np.ndarray) -> bool:
    """Return whether the most probable candidate of a query is right."""
    relation, features, right = one
    return bool(len(features) and right[int((features @ weights[relation]).argmax())])


if __name__ == "__main__":
    main()
