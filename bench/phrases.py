"""Measure how often a noun phrase finds its thing in a home with true masks: `python -m bench.phrases [SPLIT] [RESULTS]`.

In the first tour of every scene of SPLIT (by default everyday), true masks cut out the things that can be moved. Each phrase of a
category that the scene shows picks the thing that most probably is what it means, as the joint agent names objects. It is right
if the thing is of the category. RESULTS is the folder of a whole run. Each source of phrases counts alone; "noun" is the
category's own.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np

from ovman.agents.joint.decision import Nouns
from ovman.language import noun
from ovman.language.phrases import NOUN, Phrase, list_phrases
from ovman.perception import tour_files
from ovman.perception.detections import detect_views
from ovman.perception.encoder import Encoder
from ovman.perception.labels import NOTHING, TrueMasks, categories_of, label_tour
from ovman.perception.networks import encoder_of
from ovman.records.episode import Episode
from ovman.records.scene import Scene
from ovman.records.visit import Visit, tour_path
from ovman.settings import Settings
from ovman.settings.config import load_files
from ovman.shipped import HOME


def embed_things(tour: Path, encoder: Encoder, settings: Settings) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the embeddings (N, K) and the pixels (N,) of the true masks of each instance in a tour."""
    views = list(tour_files.tour(tour, settings.camera.field_of_view_deg))
    sizes = settings.perception.detector.min_mask_px, settings.perception.encoder.crop_padding
    seen = detect_views(views, TrueMasks(tour), encoder, *sizes)
    names = tuple(sorted({name for view in Visit.load(tour).views for name in view.instances}))
    shows = label_tour(seen, tour, {name: name for name in names}, names).category
    return {
        names[k]: (seen.feature[shows == k].astype(float), seen.pixels[shows == k]) for k in np.unique(shows[shows != NOTHING])
    }


def ask(things: dict[str, tuple[np.ndarray, np.ndarray]], of: dict[str, str], nouns: Nouns) -> Iterator[tuple[str, bool, float]]:
    """Yield the source of each phrase, whether it picks a thing of its category, and the share of things that would be right.

    of: Category of each instance.
    """
    names = sorted(things)
    for category in sorted({of[name] for name in names}):
        right = np.array([of[name] == category for name in names])
        foreign = [one for some in list_phrases(category).values() for one in some if one.source != NOUN]
        for one in (Phrase(noun(category), NOUN), *foreign):
            scores = [np.average(nouns.log_probability(f, one.text), weights=np.sqrt(px)) for f, px in (things[n] for n in names)]
            yield one.source, bool(right[int(np.argmax(scores))]), float(right.mean())


def main() -> None:
    """Print the rates of a split's first tours."""
    split = sys.argv[1] if len(sys.argv) > 1 else "everyday"
    results = Path(sys.argv[2] if len(sys.argv) > 2 else "results")
    episodes, visits = results / "episodes" / f"{split}.jsonl", results / "visits"
    if not (episodes.is_file() and visits.is_dir()):
        print(f"{results} has no recorded tours of {split}; run `snakemake --cores 2 results/all` first")
        return
    settings = load_files([HOME / "config.yaml"])
    encoder = encoder_of(settings.perception)
    nouns = Nouns(cache(lambda phrase: encoder.texts([phrase])[0]), settings.joint)
    first = {one.scene: one.visits.first for one in Episode.load(episodes)}
    rows = defaultdict[str, list[tuple[bool, float]]](list)
    for scene in Scene.read(results / "scenes" / f"{split}.jsonl"):
        if scene.scene in first:
            things = embed_things(tour_path(visits / scene.scene, first[scene.scene]), encoder, settings)
            for source, is_right, chance in ask(things, categories_of(scene), nouns):
                rows[source].append((is_right, chance))
    for source, found in sorted(rows.items()):
        rate, chance = np.mean(found, axis=0)
        print(f"{source}: {rate:.3f} of {len(found)}, chance {chance:.3f}")


if __name__ == "__main__":
    main()
