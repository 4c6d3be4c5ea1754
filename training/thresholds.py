"""Choose thresholds of the baselines that the benchmark's own networks need on another scale than the released ones.

    python -m training.thresholds localisation [--config config.yaml] [--views 100]
    python -m training.thresholds resemblance [--config config.yaml] [--views 48]

`localisation` scores cow.similarity by the F1 of CoW's localiser. `resemblance` scores two thresholds: dynamem.similarity, the
cosine from which a detection is called by a noun, by F1, and react.appearance, the distance up to which two objects of a category
look alike, by the mean share of pairs that it classifies rightly. Two detections look alike if they have the same asset. Looks
are means over views, so that the distance depends on their number: 48 views are those of two tours, compared half with half.

All views are from random places of the held-out floor plans, which neither the benchmark nor the trainings use.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman import seeds
from ovman.agents.cow.localiser import OpenVocabularyLocaliser, make_localiser, prompt
from ovman.language import noun
from ovman.perception.encoder import crop
from ovman.perception.networks import detector_of, encoder_of
from ovman.settings import Settings
from ovman.settings.config import load
from ovman.shipped import HOME
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import AgentPose, Session
from ovman.sim.world import is_dynamic
from training.floorplans import floor_plans
from training.pictures import Picture, picture_of

LOCALISATION = np.arange(0.1, 0.7, 0.0025)
COSINES, DISTANCES = np.arange(0.1, 0.8, 0.0025), np.arange(0.05, 1.2, 0.0125)
"""The thresholds that are tried."""
AROUND = 8
"""Thresholds that are printed on either side of the best one."""


@dataclass(frozen=True, slots=True)
class Search:
    """The search for a category in one view.

    right, wrong: the greatest similarity of a detection that is of the category, and of one that is not, or -1. shown: whether
    the category is in view.
    """

    right: float
    wrong: float
    shown: bool


@dataclass(frozen=True, slots=True)
class SearchScore:
    """Numbers of searches with a right, a wrong and a missed detection at a threshold."""

    threshold: float
    right: int
    wrong: int
    missed: int

    @property
    def f1(self) -> float:
        """2 TP / (2 TP + FP + FN)."""
        return 2 * self.right / max(2 * self.right + self.wrong + self.missed, 1)


@dataclass(frozen=True, slots=True)
class AlikeScore:
    """Shares of the pairs of one asset, and of the pairs of two, that a threshold of distance classifies rightly."""

    threshold: float
    alike: float
    unlike: float

    @property
    def mean(self) -> float:
        """Mean of both shares, which does not depend on the numbers of pairs."""
        return (self.alike + self.unlike) / 2


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """Category and asset of the object that a mask shows, "" if unknown, and the unit feature (K,) of its crop."""

    category: str
    asset: str
    feature: np.ndarray


Looks = Mapping[tuple[str, str], np.ndarray]
"""The unit mean of the features (K,) of each asset, by (category, asset)."""


def score_searches(searches: Sequence[Search], thresholds: np.ndarray) -> list[SearchScore]:
    """Score all thresholds, in their order."""
    right, wrong, shown = (np.array([getattr(one, name) for one in searches]) for name in ("right", "wrong", "shown"))
    return [
        SearchScore(float(t), int((right >= t).sum()), int((wrong >= t).sum()), int((shown & (right < t)).sum()))
        for t in thresholds
    ]


def score_distances(same: np.ndarray, other: np.ndarray, thresholds: np.ndarray) -> list[AlikeScore]:
    """Score all thresholds, in their order, on the distances of pairs of one asset and of pairs of two."""
    return [AlikeScore(float(t), float((same <= t).mean()), float((other > t).mean())) for t in thresholds]


def _categories_in_view(picture: Picture, min_mask_px: float) -> set[str]:
    return {shown.type for shown, size in zip(picture.objects, picture.sizes(), strict=True) if size >= min_mask_px}


def search_boxes(
    picture: Picture, texts: Mapping[str, np.ndarray], eyes: OpenVocabularyLocaliser, min_mask_px: float
) -> Iterator[Search]:
    """Search every category of `texts` (embeddings of prompts) among CoW's boxes, which show what their centre is on."""
    boxes, features = eyes.instances(picture.rgb)
    middle = [picture.ids[int((top + bottom) / 2), int((left + right) / 2)] for top, left, bottom, right in boxes]
    at = [picture.objects[i].type if i >= 0 else "" for i in middle]
    there = _categories_in_view(picture, min_mask_px)
    for category, text in texts.items():
        similarity, on = features @ text, np.array([name == category for name in at], bool)
        yield Search(similarity[on].max(initial=-1.0), similarity[~on].max(initial=-1.0), category in there)


def search_detections(
    picture: Picture, seen: Sequence[Detection], nouns: Mapping[str, np.ndarray], min_mask_px: float
) -> Iterator[Search]:
    """Search every category of `nouns` (embeddings) among the detections of a picture."""
    there = _categories_in_view(picture, min_mask_px)
    for category, phrase in nouns.items():
        cosines = np.array([float(one.feature @ phrase) for one in seen])
        right = np.array([one.category == category for one in seen], bool)
        yield Search(cosines[right].max(initial=-1.0), cosines[~right].max(initial=-1.0), category in there)


def name_detections(picture: Picture, masks: Sequence[np.ndarray], features: np.ndarray) -> Iterator[Detection]:
    """Name each mask (H, W) bool after the object that most of its pixels show; features (N, K)."""
    for mask, feature in zip(masks, features, strict=True):
        inside = picture.ids[mask]
        known = inside[inside >= 0]
        if 2 * len(known) < len(inside):
            yield Detection("", "", feature)
            continue
        shown = picture.objects[int(np.bincount(known).argmax())]
        yield Detection(shown.type, shown.asset, feature)


def average_looks(seen: Sequence[Detection]) -> Looks:
    """Return how each asset of known category looks in some views."""
    of_asset: dict[tuple[str, str], list[np.ndarray]] = {}
    for one in seen:
        if one.category and one.asset:
            of_asset.setdefault((one.category, one.asset), []).append(one.feature)
    means = {key: np.mean(features, axis=0) for key, features in of_asset.items()}
    tiny = float(np.finfo(np.float32).tiny)
    return {key: mean / max(float(np.linalg.norm(mean)), tiny) for key, mean in means.items()}


def measure_pairs(halves: Sequence[tuple[Looks, Looks]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances of looks between the two halves of the views of floor plans.

    The first are of one asset of a plan to itself, the second of each asset to every other one of its category, of any plan.
    """
    same = [float(np.linalg.norm(ours[key] - theirs[key])) for ours, theirs in halves for key in sorted(ours.keys() & theirs)]
    other = [
        float(np.linalg.norm(ours[mine] - theirs[key]))
        for ours, _ in halves
        for mine in ours
        for _, theirs in halves
        for key in theirs
        if mine[0] == key[0] and mine != key
    ]
    return np.array(same), np.array(other)


def take_views(session: Session, count: int, rng: np.random.Generator) -> Iterator[tuple[Picture, list[str]]]:
    """Yield pictures from random places and headings, with the movable categories of the scene."""
    session.reset()
    categories = sorted({o["objectType"] for o in session.objects.values() if is_dynamic(o)})
    places = sorted(session.reachable())
    for _ in range(count):
        x, z = places[rng.integers(len(places))]
        yield picture_of(session.teleport(AgentPose(x, z, float(rng.uniform(0.0, 360.0))), image=True)), categories


def _print_best(title: str, columns: str, in_use: float, lines: Sequence[tuple[float, str]]) -> None:
    """Print the lines of thresholds around the best one. lines: the merit of each threshold, and its line."""
    best = int(np.argmax([merit for merit, _ in lines]))
    print(f"{title}: best {lines[best][0]:.3f}; in use: {in_use}\n{columns}")
    for _, line in lines[max(best - AROUND, 0) : best + AROUND + 1]:
        print(line)


def _print_searches(title: str, in_use: float, found: Sequence[SearchScore]) -> None:
    lines = [(one.f1, f"{one.threshold:9.4f}{one.f1:8.3f}{one.right:8}{one.wrong:8}{one.missed:8}") for one in found]
    _print_best(title, f"{'threshold':>9}{'F1':>8}{'right':>8}{'wrong':>8}{'missed':>8}", in_use, lines)


def score_localisation(settings: Settings, count: int) -> None:
    """Print the scores of cow.similarity on `count` of the LoCoBot's views per held-out floor plan."""
    body = Embodiment.named("locobot", settings)
    encoder = encoder_of(settings.perception)
    eyes = make_localiser(settings, detector_of(settings.perception), encoder)
    eyes.look_for("Floor")
    share = settings.perception.detector.min_mask_px / (settings.camera.width_px * settings.camera.height_px)
    searches: list[Search] = []
    for scene in floor_plans(settings.splits["main"].scenes).held_out:
        with Session(scene, settings, body) as session:
            texts: dict[str, np.ndarray] = {}
            for picture, categories in take_views(session, count, seeds.generator(0, "localisation", scene)):
                texts = texts or dict(zip(categories, encoder.texts([prompt(c) for c in categories]), strict=True))
                searches += search_boxes(picture, texts, eyes, share * picture.ids.size)
    print(f"{len(searches)} searches, {sum(one.shown for one in searches)} of them for a category in view")
    _print_searches("F1 of CoW's localiser", settings.cow.similarity, score_searches(searches, LOCALISATION))


def score_resemblance(settings: Settings, count: int) -> None:
    """Print the scores of dynamem.similarity and react.appearance on `count` views per held-out floor plan."""
    perception = settings.perception
    detector, encoder = detector_of(perception), encoder_of(perception)
    min_mask_px, padding = perception.detector.min_mask_px, perception.encoder.crop_padding
    searches: list[Search] = []
    of_plans: list[tuple[Looks, Looks]] = []
    for scene in floor_plans(settings.splits["main"].scenes).held_out:
        halves: tuple[list[Detection], list[Detection]] = ([], [])
        nouns: dict[str, np.ndarray] = {}
        with Session(scene, settings, Embodiment.of(settings)) as session:
            taken = take_views(session, count, seeds.generator(0, "resemblance", scene))
            for number, (picture, categories) in enumerate(taken):
                nouns = nouns or dict(zip(categories, encoder.texts([noun(c) for c in categories]), strict=True))
                masks = [m for m in detector.detect([picture.rgb])[0].masks if np.count_nonzero(m) >= min_mask_px]
                if not masks:
                    continue
                crops = np.stack([crop(picture.rgb, mask, padding, encoder.side_px, encoder.contrast) for mask in masks])
                seen = list(name_detections(picture, masks, encoder.images(crops)))
                searches += search_detections(picture, seen, nouns, min_mask_px)
                halves[number % 2].extend(seen)
        of_plans.append((average_looks(halves[0]), average_looks(halves[1])))
        print(f"{scene}: {sum(map(len, halves))} detections", flush=True)
    _print_searches("F1 of the cosine to the noun", settings.dynamem.similarity, score_searches(searches, COSINES))
    same, other = measure_pairs(of_plans)
    alike = score_distances(same, other, DISTANCES)
    lines = [(one.mean, f"{one.threshold:9.4f}{one.mean:8.3f}{one.alike:8.3f}{one.unlike:8.3f}") for one in alike]
    print(f"{len(same)} pairs of one asset, {len(other)} of two")
    columns = f"{'distance':>9}{'mean':>8}{'alike':>8}{'unlike':>8}"
    _print_best("mean share of the distance of looks", columns, settings.react.appearance, lines)


SCORERS = {"localisation": (score_localisation, 100), "resemblance": (score_resemblance, 48)}
"""What can be scored, and its views per floor plan."""


def main() -> None:
    """Print the scores of the thresholds around the best one."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=SCORERS)
    parser.add_argument("--config", type=Path, default=HOME / "config.yaml")
    parser.add_argument("--views", type=int, help="per floor plan; default: 100 for localisation, 48 for resemblance")
    options = parser.parse_args()
    score, views = SCORERS[options.what]
    score(load(options.config), options.views or views)


if __name__ == "__main__":
    main()
