"""The two thresholds on the encoder's features that the rivals' own networks state on other scales.

    python -m ovman.training.resemblance [--config config.yaml] [--views 48]

`dynamem.similarity` is the cosine from which a detection is what a noun means, `react.appearance` the distance up to which two
objects of a category look alike. Both are chosen on views from random places of the held-out floor plans, which neither the
benchmark nor the trainings use. Looking alike is having the same asset: what one half of a floor plan's views shows is set beside
what the other half shows of the category. Looks are means over views, so that the distance depends on their number.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman import seeds
from ovman.language import noun
from ovman.perception.crop import crop
from ovman.perception.networks import detector_of, encoder_of
from ovman.settings.config import load
from ovman.shipped import HOME
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import Session
from ovman.training.floorplans import floor_plans
from ovman.training.localisation import Looked, scores, views
from ovman.training.pictures import Picture

COSINES, DISTANCES = np.arange(0.3, 0.8, 0.0025), np.arange(0.05, 1.2, 0.0125)
"""The thresholds that are tried."""


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """What a mask shows, "" for nothing that is known, and the unit feature (K,) of its crop."""

    category: str
    asset: str
    feature: np.ndarray


def detections(picture: Picture, masks: Sequence[np.ndarray], features: np.ndarray) -> Iterator[Detection]:
    """Each mask (H, W) bool as the object that most of its pixels show; features (N, K)."""
    for mask, feature in zip(masks, features, strict=True):
        inside = picture.ids[mask]
        known = inside[inside >= 0]
        if 2 * len(known) < len(inside):
            yield Detection("", "", feature)
            continue
        shown = picture.objects[int(np.bincount(known).argmax())]
        yield Detection(shown.type, shown.asset, feature)


def looked_for(
    picture: Picture, seen: Sequence[Detection], nouns: Mapping[str, np.ndarray], min_mask_px: float
) -> Iterator[Looked]:
    """The search for every category of `nouns` (embeddings) among the detections of a picture."""
    sizes = np.bincount(picture.ids[picture.ids >= 0], minlength=len(picture.objects))
    there = {shown.type for shown, size in zip(picture.objects, sizes, strict=True) if size >= min_mask_px}
    for category, phrase in nouns.items():
        cosines = np.array([float(one.feature @ phrase) for one in seen])
        right = np.array([one.category == category for one in seen], bool)
        yield Looked(cosines[right].max(initial=-1.0), cosines[~right].max(initial=-1.0), category in there)


@dataclass(frozen=True, slots=True)
class AlikeScore:
    """Shares of the pairs of one asset, and of the pairs of two, that a threshold of distance tells rightly."""

    threshold: float
    alike: float
    unlike: float

    @property
    def mean(self) -> float:
        """Of both shares, so that it does not depend on how many pairs there are of either sort."""
        return (self.alike + self.unlike) / 2


Looks = Mapping[tuple[str, str], np.ndarray]
"""The unit mean of the features (K,) of each asset by (category, asset)."""


def looks(seen: Sequence[Detection]) -> Looks:
    """How each asset of known category looks in some views."""
    of_asset: dict[tuple[str, str], list[np.ndarray]] = {}
    for one in seen:
        if one.category and one.asset:
            of_asset.setdefault((one.category, one.asset), []).append(one.feature)
    return {key: _unit(np.mean(features, axis=0)) for key, features in of_asset.items()}


def pairs(halves: Sequence[tuple[Looks, Looks]]) -> tuple[np.ndarray, np.ndarray]:
    """Distances of looks between the two halves of the views of floor plans: of one asset of a plan to itself, and of each asset
    to every other one of its category, of whatever plan.
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


def alike_scores(same: np.ndarray, other: np.ndarray, thresholds: np.ndarray) -> list[AlikeScore]:
    """Of pairs that are taken for alike up to a distance; of all thresholds in their order."""
    return [AlikeScore(float(t), float((same <= t).mean()), float((other > t).mean())) for t in thresholds]


def _unit(feature: np.ndarray) -> np.ndarray:
    unit: np.ndarray = feature / max(float(np.linalg.norm(feature)), float(np.finfo(np.float32).tiny))
    return unit


def _told(what: str, in_use: float, found: Sequence[tuple[float, str]], best: int) -> None:
    """Print the lines of scores around the best one. found: of each threshold its merit and its line."""
    print(f"{what}: best {found[best][0]:.3f}; in use: {in_use}")
    for _, line in found[max(best - 8, 0) : best + 9]:
        print(line)


def main() -> None:
    """Print the scores of the thresholds around the best ones."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, default=HOME / "config.yaml")
    parser.add_argument("--views", type=int, default=48, help="of each floor plan; 48 are those of two tours")
    options = parser.parse_args()
    settings = load(options.config)
    perception = settings.perception
    detector, encoder = detector_of(perception), encoder_of(perception)
    min_mask_px, padding = perception.detector.min_mask_px, perception.encoder.crop_padding
    looked: list[Looked] = []
    of_plans: list[tuple[Looks, Looks]] = []
    scenes = floor_plans(settings.splits["main"].scenes).held_out
    for scene in scenes:
        halves: tuple[list[Detection], list[Detection]] = ([], [])
        nouns: dict[str, np.ndarray] = {}
        with Session(scene, settings, Embodiment.of(settings)) as session:
            drawn = views(session, options.views, seeds.generator(0, "resemblance", scene))
            for number, (picture, categories) in enumerate(drawn):
                nouns = nouns or dict(zip(categories, encoder.texts([noun(c) for c in categories]), strict=True))
                masks = [m for m in detector.detect([picture.rgb])[0].masks if np.count_nonzero(m) >= min_mask_px]
                if not masks:
                    continue
                crops = np.stack([crop(picture.rgb, mask, padding, encoder.side_px) for mask in masks])
                seen = list(detections(picture, masks, encoder.images(crops)))
                looked += looked_for(picture, seen, nouns, min_mask_px)
                halves[number % 2].extend(seen)
        of_plans.append((looks(halves[0]), looks(halves[1])))
        print(f"{scene}: {sum(map(len, halves))} detections", flush=True)
    named = scores(looked, COSINES)
    lines = [(one.f1, f"{one.threshold:9.4f}{one.f1:8.3f}{one.right:8}{one.wrong:8}{one.missed:8}") for one in named]
    print(f"{'cosine':>9}{'F1':>8}{'right':>8}{'wrong':>8}{'missed':>8}")
    _told("cosine to the noun, F1", settings.dynamem.similarity, lines, int(np.argmax([merit for merit, _ in lines])))
    same, other = pairs(of_plans)
    alike = alike_scores(same, other, DISTANCES)
    lines = [(one.mean, f"{one.threshold:9.4f}{one.mean:8.3f}{one.alike:8.3f}{one.unlike:8.3f}") for one in alike]
    print(f"{len(same)} pairs of one asset, {len(other)} of two\n{'distance':>9}{'mean':>8}{'alike':>8}{'unlike':>8}")
    _told("distance of looks, mean of both", settings.react.appearance, lines, int(np.argmax([merit for merit, _ in lines])))


if __name__ == "__main__":
    main()
