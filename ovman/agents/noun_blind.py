"""The noun-blind classifier, a control: a fitted choice among all things that came or went. It reads no noun.

It is a conditional logit over the pieces of `ovman.agents.changes`. `python -m training.noun_blind SPLIT` fits noun_blind.json.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.changes import VOXEL_M, Piece, answer_at, compare_tours
from ovman.agents.interface import Abstention, AbstentionReason, Answer, PredictionContext, Query, Relation
from ovman.agents.joint.agent import recorded_segments
from ovman.agents.joint.segments import Segments

WEIGHTS = Path(__file__).with_suffix(".json")
APART_M = 1.0
"""Detections that are farther than this from a piece show another thing."""
FEATURES = (
    *("log_volume", "height_m", "bottom_m", "reach_m", "transient", "view", "spawn_m", "spawn_near"),
    *("detected", "alike_here", "alike_again", "alike_there", "size_there"),
)
"""Of a candidate: its box, its distance from free floor, motion, order, distance from the spawn (metres, and whether it is below
2 m), whether the detector saw it; the cosine of its most similar detection elsewhere in its own visit, of the next similar one a
metre from that, and of the most similar piece in the other visit; and by how much that one's box differs, in logarithms."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """N places that may answer a query: (N, 2) metres, and their features (N, len(FEATURES))."""

    places: np.ndarray
    features: np.ndarray


def predict(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm noun_blind: the most probable candidate by weights that were fitted on a dev split."""
    found = list_candidates(Relation(query.relation), context)
    if not len(found.places):
        return Abstention(AbstentionReason.NO_CANDIDATE), None
    fitted = _read_weights()
    scaled = (found.features - np.array(fitted["mean"])) / np.array(fitted["scale"])
    return answer_at(found.places[int((scaled @ np.array(fitted["weights"][query.relation])).argmax())]), None


@cache
def _read_weights() -> dict[str, Any]:
    weights: dict[str, Any] = json.loads(WEIGHTS.read_text(encoding="utf-8"))
    return weights


def list_candidates(relation: Relation, context: PredictionContext) -> Candidates:
    """Return the candidates of a relation, which reads no noun.

    They are the pieces of the visit that the relation speaks of. For STABLE each piece stands for its most similar detection
    elsewhere in the second visit: where an instance moved, its look-alike stayed.
    """
    pieces_1, pieces_2 = compare_tours(context.tour("first"), context.tour("second"), context.settings.joint)
    segments_1, segments_2 = recorded_segments(context)
    here, there = (pieces_1, pieces_2) if relation.past else (pieces_2, pieces_1)
    mine, others = (segments_1, segments_2) if relation.past else (segments_2, segments_1)
    looks = [average_look(piece, others) for piece in there]
    places, rows = [], []
    for piece in here:
        look = average_look(piece, mine)
        away = mine.named & (np.hypot(*(mine.place[:, [0, 2]] - piece.middle).T) > APART_M)
        cosine = np.where(away, mine.feature @ look, 0.0)
        best = int(cosine.argmax()) if away.any() else -1
        twin = mine.place[best, [0, 2]] if best >= 0 else piece.middle
        again = cosine[np.hypot(*(mine.place[:, [0, 2]] - twin).T) > APART_M].max(initial=0.0)
        elsewhere = [float(one @ look) if np.linalg.norm(piece.middle - k.middle) > APART_M else 0.0
                     for k, one in zip(there, looks, strict=True)]  # fmt: skip
        match = int(np.argmax(elsewhere)) if elsewhere else -1
        spawn_m = float(np.linalg.norm(piece.middle - context.spawn))
        places.append(twin if relation is Relation.STABLE else piece.place(relation))
        rows.append(
            (
                *(piece.log_volume, piece.high[1] - piece.low[1], piece.height_m, piece.reach_m, piece.transient, piece.view),
                *(spawn_m, float(spawn_m < 2.0), float(look.any()), cosine.max(initial=0.0), again),
                *((elsewhere[match], abs(piece.log_volume - there[match].log_volume)) if match >= 0 else (0.0, 3.0)),
            )
        )
    return Candidates(np.array(places).reshape(-1, 2), np.array(rows, float).reshape(-1, len(FEATURES)))


def average_look(piece: Piece, seen: Segments) -> np.ndarray:
    """Return the unit mean (K,) of the embeddings of the detections whose place is in a piece's box; zeros for none."""
    inside = seen.named & ((seen.place >= piece.low - VOXEL_M) & (seen.place <= piece.high + VOXEL_M)).all(axis=1)
    look: np.ndarray = (seen.feature[inside] * np.sqrt(seen.cells[inside])[:, None]).sum(axis=0)
    return look / (np.linalg.norm(look) or 1.0)
