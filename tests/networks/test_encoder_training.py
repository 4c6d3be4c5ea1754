"""The image tower runs as it was trained, and retrieval is counted as the cards say."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from ovman.language import noun
from training.encoder import augment, measure_retrieval
from training.towers import SIZE, build_image_tower, fix_padding, prepare

pytestmark = pytest.mark.networks


def test_fixed_padding_changes_no_number():
    torch.manual_seed(0)
    tower = build_image_tower().eval()
    crops = prepare(np.random.default_rng(0).integers(0, 256, (3, 96, 96, 3), np.uint8))
    with torch.inference_mode():
        found = tower(crops)
        assert found.shape == (3, SIZE) and torch.equal(found, fix_padding(tower, 96)(crops))


def test_augmentation_depends_on_the_generator_alone():
    crops = torch.rand(8, 3, 32, 32)
    one, other, third = (augment(crops, torch.Generator().manual_seed(seed)) for seed in (1, 1, 2))
    assert torch.equal(one, other) and not torch.equal(one, third) and one.shape == crops.shape
    assert float(one.min()) >= 0 and float(one.max()) <= 1


def test_a_crop_counts_by_the_noun_that_it_is_nearest_to():
    """Two crops of a scene are nearest to their nouns; one of them is nearer to a category that the scene lacks."""
    directions = {noun("Bed"): 0, noun("Sofa"): 1, noun("Mug"): 2, "couch": 1, "mattress": 0}

    def texts(phrases):
        found = np.zeros((len(phrases), 4), np.float32)
        for row, phrase in zip(found, phrases, strict=True):
            row[directions.get(phrase, 3)] = 1
        return found

    scene = SimpleNamespace(types=np.array(["Bed", "Sofa"]))
    seen = np.array([[1, 0, 0, 0], [0, 0.6, 0.8, 0]], np.float32)
    rates = measure_retrieval([scene], [seen], texts)
    assert (rates.all_nouns, rates.top1, rates.top5, rates.unseen_words) == (0.5, 1.0, 1.0, 0.0)
    assert 0 < rates.synonyms_top1 < 1
