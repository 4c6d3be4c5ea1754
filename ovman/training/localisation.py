"""F1 of CoW's localiser by threshold; cow.similarity of config.yaml is chosen by it.

    python -m ovman.training.localisation [--config config.yaml] [--views 100]

The views are the LoCoBot's from random places of the held-out floor plans, which neither the benchmark nor the trainings use.
Every movable category of a floor plan is searched in each of its views.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman import seeds
from ovman.agents.cow.localiser import OpenVocabularyLocaliser, make_localiser, prompt
from ovman.perception.networks import detector_of, encoder_of
from ovman.settings.config import load
from ovman.shipped import HOME
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import AgentPose, Session
from ovman.sim.world import is_dynamic
from ovman.training.floorplans import floor_plans
from ovman.training.pictures import Picture, picture_of

STEP = 0.0025
"""Difference of two thresholds."""


@dataclass(frozen=True, slots=True)
class Looked:
    """The search for a category in one view.

    right, wrong: the greatest similarity of a box whose centre is on the category, and of one whose centre is on something else,
    or -1. shown: whether the category is in view.
    """

    right: float
    wrong: float
    shown: bool


@dataclass(frozen=True, slots=True)
class ThresholdScore:
    """Numbers of searches with a right, a wrong and a missed detection at a threshold."""

    threshold: float
    right: int
    wrong: int
    missed: int

    @property
    def f1(self) -> float:
        """2 TP / (2 TP + FP + FN)."""
        return 2 * self.right / max(2 * self.right + self.wrong + self.missed, 1)


def scores(looked: list[Looked], thresholds: np.ndarray) -> list[ThresholdScore]:
    """The scores of all thresholds, in their order."""
    right, wrong, shown = (np.array([getattr(one, name) for one in looked]) for name in ("right", "wrong", "shown"))
    return [
        ThresholdScore(float(t), int((right >= t).sum()), int((wrong >= t).sum()), int((shown & (right < t)).sum()))
        for t in thresholds
    ]


def views(session: Session, count: int, rng: np.random.Generator) -> Iterator[tuple[Picture, list[str]]]:
    """Pictures from random places and headings, and the movable categories of the scene."""
    session.reset()
    categories = sorted({o["objectType"] for o in session.objects.values() if is_dynamic(o)})
    places = sorted(session.reachable())
    for _ in range(count):
        x, z = places[rng.integers(len(places))]
        yield picture_of(session.teleport(AgentPose(x, z, float(rng.uniform(0.0, 360.0))), image=True)), categories


def looked_for(
    picture: Picture, texts: dict[str, np.ndarray], eyes: OpenVocabularyLocaliser, min_mask_px: float
) -> Iterator[Looked]:
    """The search for every category of `texts` (embeddings of prompts); an instance of `min_mask_px` pixels counts as in view."""
    boxes, features = eyes.instances(picture.rgb)
    middle = [picture.ids[int((top + bottom) / 2), int((left + right) / 2)] for top, left, bottom, right in boxes]
    at = [picture.objects[i].type if i >= 0 else "" for i in middle]
    sizes = np.bincount(picture.ids[picture.ids >= 0], minlength=len(picture.objects))
    there = {shown.type for shown, size in zip(picture.objects, sizes, strict=True) if size >= min_mask_px}
    for category, text in texts.items():
        similarity, on = features @ text, np.array([name == category for name in at], bool)
        yield Looked(similarity[on].max(initial=-1.0), similarity[~on].max(initial=-1.0), category in there)


def main() -> None:
    """Print the scores of the thresholds around the best one."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, default=HOME / "config.yaml")
    parser.add_argument("--views", type=int, default=100, help="of each floor plan")
    options = parser.parse_args()
    settings = load(options.config)
    body = Embodiment.named("locobot", settings)
    encoder = encoder_of(settings.perception)
    eyes = make_localiser(settings, detector_of(settings.perception), encoder)
    eyes.look_for("Floor")
    share = settings.perception.detector.min_mask_px / (settings.camera.width_px * settings.camera.height_px)
    looked: list[Looked] = []
    scenes = floor_plans(settings.splits["main"].scenes).held_out
    for scene in scenes:
        with Session(scene, settings, body) as session:
            texts: dict[str, np.ndarray] = {}
            for picture, categories in views(session, options.views, seeds.generator(0, "localisation", scene)):
                texts = texts or dict(zip(categories, encoder.texts([prompt(c) for c in categories]), strict=True))
                looked += looked_for(picture, texts, eyes, share * picture.ids.size)
    found = scores(looked, np.arange(0.4, 0.7, STEP))
    best = max(found, key=lambda score: score.f1)
    shown = sum(one.shown for one in looked)
    print(f"{len(scenes)} floor plans, {options.views} views each: {len(looked)} searches, {shown} of them for what is in view")
    print(f"best F1 {best.f1:.3f} at {best.threshold:.4f}; in use: {settings.cow.similarity}")
    print(f"{'threshold':>9}{'F1':>8}{'right':>8}{'wrong':>8}{'missed':>8}")
    for score in found:
        if abs(score.threshold - best.threshold) < 8.5 * STEP:
            print(f"{score.threshold:9.4f}{score.f1:8.3f}{score.right:8}{score.wrong:8}{score.missed:8}")


if __name__ == "__main__":
    main()
