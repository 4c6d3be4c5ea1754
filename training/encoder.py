"""Train the image tower of the encoder on crops with captions: published weights, drawn towards the text tower's embeddings.

The text tower stays as it was published. A softmax over all captions takes those of a crop's category as its targets; a second
one does so for its category with its colour ("a blue chair").
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F

from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS, nouns
from ovman.perception.encoder import Texts
from ovman.perception.networks import text_tower
from ovman.settings import Settings
from training.captions import COLOURS, Captions, Senses, colour_word, make_captions, unseen_words
from training.crops import Crops
from training.export import quantise_tower, write_encoder
from training.public import read_public
from training.towers import POOLED, SIZE, build_head, build_image_tower, normalise, prepare

WARM_STEPS, CLIPPED, MEMORY = 100, 1.0, 0.995
"""MEMORY: decay of the moving average of the weights; the average is saved."""
FROZEN = 4
"""Stages that stay as they were published: that saves two fifths of the time of a step."""
HEAD_FASTER = 3.0
"""Learning rate of the random last layer over that of the published ones."""
SCALE, COLOURED = 20.0, 0.3
"""Logit scale, and weight of the loss with colours."""
SMOOTH = 0.05
"""Share of a target that is spread over all captions."""
CHUNK = 128
RANGED = 512
"""Crops on which the ranges of the tower's values are measured, for its eight bits."""
HEAD_EPOCHS, HEAD_BATCH, HEAD_RATE, LEAST_DEVIATION = 10, 512, 0.002, 0.001
MIRRORED, BLURRED, HIDDEN = 0.5, 0.15, 0.15
"""Shares of mirrored, blurred and partly occluded crops."""
ZOOM, SHIFT, TURN_RAD = (0.8, 1.15), 0.1, 0.06
GAIN, OFFSET, NOISE = (0.75, 1.25), 0.06, 0.02
PATCH = (0.05, 0.2)
"""Half sides of an occluder as a share of the crop's side."""


@dataclass(frozen=True, slots=True)
class RetrievalRates:
    """Share of crops whose category is first, or among the first five.

    all_nouns: among the nouns of all categories; top1, top5: among those of the scene; synonyms_top1: among these, with a
    synonym of the right category in place of its noun; unseen_words: the same, with words that no caption has.
    """

    all_nouns: float
    top1: float
    top5: float
    synonyms_top1: float
    unseen_words: float


class TrainingSet:
    """Crops and the embeddings of all captions."""

    def __init__(self, crops: Crops, categories: Sequence[str], captions: Captions, texts: Texts) -> None:
        number = {category: k for k, category in enumerate(categories)}
        self.images = torch.from_numpy(crops.images)
        self.labels = torch.tensor([number[category] for category in crops.types.tolist()])
        colours = torch.tensor([COLOURS.index(colour_word(colour)) for colour in crops.colours])
        self.coloured_labels = self.labels * len(COLOURS) + colours
        self.share = torch.from_numpy(captions.share)
        self.texts, self.coloured = (torch.from_numpy(texts(of)) for of in (captions.texts, captions.coloured))
        counts = np.bincount(self.labels.numpy(), minlength=len(categories))
        self.chance = torch.from_numpy(1 / np.sqrt(counts[self.labels.numpy()]))


def run(
    taught: Sequence[Path],
    held_out: Mapping[str, Sequence[Path]],
    texts: Path,
    settings: Settings,
    weights: Path,
    graph: Path,
    curve: Path,
) -> None:
    """Train on the crops of the files `taught`: first the tower, then, on what it gives in eight bits, a new head.

    held_out: files of crops by kind of scene, for evaluation only; texts: graph of the text tower. Writes weights (.safetensors,
    half precision), their graph, and the curve (JSON lines).
    """
    crops = Crops.join([Crops.read(path) for path in taught])
    categories = sorted({*SYNONYMS, *crops.types.tolist()} - {*settings.training.left_out})
    captions = make_captions(categories, Senses.read(read_public("senses").decode()))
    embed = text_tower(texts)
    lessons = TrainingSet(crops, categories, captions, embed)
    shown = {name: [Crops.read(path) for path in files] for name, files in held_out.items()}
    print(f"{len(crops.types)} crops of {len(categories)} categories, {len(captions.texts)} captions", flush=True)
    curve.write_text("")
    began = time.monotonic()

    def look(step: int, loss: float, features: Callable[[np.ndarray], np.ndarray]) -> None:
        rates = {
            name: asdict(measure_retrieval(parts, [features(part.images) for part in parts], embed, captions))
            for name, parts in shown.items()
        }
        record = {"step": step, "minutes": round((time.monotonic() - began) / 60, 1), "loss": round(loss, 4)}
        line = json.dumps(record | {name: {k: round(v, 4) for k, v in rate.items()} for name, rate in rates.items()})
        with curve.open("a", encoding="utf-8") as file:
            file.write(line + "\n")
        print(line, flush=True)

    tower = train_tower(lessons, settings, look)
    finish(tower, lessons, settings, look, texts, weights, graph)


Look = Callable[[int, float, Callable[[np.ndarray], np.ndarray]], None]
"""Evaluates after a step with a loss; the function gives unit embeddings of crops."""


def train_tower(lessons: TrainingSet, settings: Settings, look: Look) -> Any:
    """Return the tower after training.encoder.steps, with a linear head."""
    training, seed = settings.training.encoder, settings.training.seed
    torch.manual_seed(seed)
    generator = torch.Generator().manual_seed(seed)
    model = build_image_tower(published=True)
    frozen = (model.conv_stem, model.bn1, *model.blocks[:FROZEN])
    for part in frozen:
        part.requires_grad_(False)
    average = {name: value.detach().clone().float() for name, value in model.state_dict().items()}
    optimiser = _optimiser(model, training.learning_rate, training.weight_decay)
    peaks = [group["lr"] for group in optimiser.param_groups]
    kept = build_image_tower()
    for step in range(1, training.steps + 1):
        for group, peak in zip(optimiser.param_groups, peaks, strict=True):
            group["lr"] = peak * min(1.0, step / WARM_STEPS) * 0.5 * (1 + math.cos(math.pi * step / training.steps))
        model.train()
        for part in frozen:
            part.eval()
        batch = torch.multinomial(lessons.chance, training.batch, replacement=True, generator=generator)
        images = augment(lessons.images[batch].permute(0, 3, 1, 2).float() / 255, generator)
        loss = _loss(model(normalise(images)), lessons, batch)
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), CLIPPED)
        optimiser.step()
        keep = min(MEMORY, step / (step + 10))
        with torch.no_grad():
            for name, value in model.state_dict().items():
                average[name].lerp_(value.float(), 1 - keep)
        if step % training.look_every == 0 or step == training.steps:
            kept.load_state_dict({name: value.to(kept.state_dict()[name].dtype) for name, value in average.items()})
            look(step, loss.item(), partial(embed_images, kept.eval()))
    return kept


def finish(
    tower: Any,
    lessons: TrainingSet,
    settings: Settings,
    look: Look,
    texts: Path,
    weights: Path,
    graph: Path,
) -> None:
    """Train a new head on the features that the tower gives in eight bits; write the weights and the graph.

    Eight bits cost .08 of the rate of the first head, which learned from features in single precision.
    """
    from safetensors.torch import save_file

    training, seed = settings.training.encoder, settings.training.seed
    torch.manual_seed(seed)
    generator = torch.Generator().manual_seed(seed)
    body = deepcopy(tower).eval()
    body.reset_classifier(0)
    shown = lessons.images[:: max(len(lessons.images) // RANGED, 1)].numpy()
    quantised = quantise_tower(body, shown)

    def pool(images: np.ndarray) -> torch.Tensor:
        parts = [prepare(images[k : k + CHUNK]).contiguous().numpy() for k in range(0, len(images), CHUNK)]
        return torch.from_numpy(np.concatenate([np.zeros((0, POOLED), np.float32), *(quantised(part)[0] for part in parts)]))

    features = pool(lessons.images.numpy())
    mean, deviation = features.mean(0), features.std(0) + LEAST_DEVIATION
    head = build_head()
    steps = HEAD_EPOCHS * len(features) // HEAD_BATCH
    optimiser = torch.optim.AdamW(head.parameters(), weight_decay=training.weight_decay)
    rate = torch.optim.lr_scheduler.OneCycleLR(optimiser, HEAD_RATE, total_steps=steps)
    for _ in range(steps):
        batch = torch.multinomial(lessons.chance, HEAD_BATCH, replacement=True, generator=generator)
        loss = _loss(head((features[batch] - mean) / deviation), lessons, batch)
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        optimiser.step()
        rate.step()
    with torch.no_grad():  # what scales the features becomes part of the head
        head[1].weight /= deviation
        head[1].bias -= head[1].weight @ mean
    head.eval()
    with torch.inference_mode():
        look(training.steps + steps, loss.item(), lambda images: F.normalize(head(pool(images)), dim=-1).numpy())
    tower.classifier = head
    save_file({name: value.half().contiguous() for name, value in tower.state_dict().items()}, weights)
    write_encoder(weights, texts, shown, graph)


def _optimiser(model: Any, peak: float, weight_decay: float) -> torch.optim.Optimizer:
    head = [*model.get_classifier().parameters()]
    body = [p for p in model.parameters() if p.requires_grad and all(p is not other for other in head)]
    groups = [
        {"params": [p for p in body if p.ndim >= 2], "weight_decay": weight_decay, "lr": peak},
        {"params": [p for p in body if p.ndim < 2], "weight_decay": 0.0, "lr": peak},
        {"params": head, "weight_decay": weight_decay, "lr": HEAD_FASTER * peak},
    ]
    return torch.optim.AdamW(groups)


def _loss(embedded: torch.Tensor, lessons: TrainingSet, batch: torch.Tensor) -> torch.Tensor:
    seen = SCALE * F.normalize(embedded, dim=-1)
    target = lessons.share[:, lessons.labels[batch]].T
    loss = F.cross_entropy(seen @ lessons.texts.T, target, label_smoothing=SMOOTH)
    return loss + COLOURED * F.cross_entropy(seen @ lessons.coloured.T, lessons.coloured_labels[batch])


@torch.no_grad()
def embed_images(model: Any, images: np.ndarray) -> np.ndarray:
    """Return unit embeddings (N, SIZE) of crops (N, S, S, 3) by a tower in evaluation mode."""
    parts = [model(prepare(images[k : k + CHUNK])) for k in range(0, len(images), CHUNK)]
    found: np.ndarray = F.normalize(torch.cat([torch.zeros(0, SIZE), *parts]), dim=-1).numpy()
    return found


def measure_retrieval(
    scenes: Sequence[Crops], features: Sequence[np.ndarray], texts: Texts, captions: Captions | None = None
) -> RetrievalRates:
    """Measure how often the embeddings of scenes' crops are nearest to the noun of their category.

    A word that several categories share is right for each of them. captions: those of the training; without them the words that
    no caption has are not measured.
    """
    shown = {t for crops in scenes for t in crops.types.tolist()}
    every = sorted({*SYNONYMS, *shown})
    unseen: dict[str, list[str]] = {}
    for category, word in unseen_words(shown, captions) if captions else ():
        unseen.setdefault(category, []).append(word)
    words = {noun(c) for c in every} | {w for c in shown for w in (*nouns(c), *unseen.get(c, ()))}
    said = dict(zip(sorted(words), texts(sorted(words)), strict=True))
    all_nouns = np.stack([said[noun(c)] for c in every])
    counts = np.zeros(4)  # right among all nouns, first, among five, and all
    sums = {"synonyms": [0.0, 0.0], "unseen": [0.0, 0.0]}
    for crops, seen in zip(scenes, features, strict=True):
        if not len(crops.types):
            continue
        categories = np.unique(crops.types).tolist()
        labels = np.array([categories.index(c) for c in crops.types.tolist()])
        similar = seen @ np.stack([said[noun(c)] for c in categories]).T
        rank = (similar > similar[np.arange(len(labels)), labels][:, None]).sum(axis=1)
        best = (seen @ all_nouns.T).argmax(axis=1)
        counts += (crops.types == np.array(every)[best]).sum(), (rank < 1).sum(), (rank < 5).sum(), len(rank)
        for number, category in enumerate(categories):
            here = labels == number
            for kind, others in (("synonyms", nouns(category)[1:]), ("unseen", unseen.get(category, ()))):
                for word in others:
                    rivals = [k for k, c in enumerate(categories) if k != number and word not in nouns(c)]
                    rival = similar[here][:, rivals].max(axis=1) if rivals else np.full(here.sum(), -1.0)
                    sums[kind][0] += float((seen[here] @ said[word] > rival).sum()) / len(others)
                sums[kind][1] += float(here.sum()) if others else 0.0
    total = max(counts[3], 1)
    shares = [value / max(number, 1) for value, number in sums.values()]
    return RetrievalRates(*(float(v) for v in (*counts[:3] / total, *shares)))


def augment(crops: torch.Tensor, generator: torch.Generator) -> torch.Tensor:
    """Return augmented crops (B, 3, S, S) in [0, 1]; equal for a generator in the same state."""
    count, _, side, _ = crops.shape

    def uniform(low: float, high: float, *shape: int) -> torch.Tensor:
        return torch.rand(*shape, generator=generator, device=crops.device) * (high - low) + low

    zoom, mirror = uniform(*ZOOM, count), torch.where(uniform(0, 1, count) < MIRRORED, -1.0, 1.0)
    turn = torch.randn(count, generator=generator, device=crops.device) * TURN_RAD
    place = torch.zeros(count, 2, 3, device=crops.device)
    place[:, 0, 0], place[:, 0, 1] = zoom * mirror * turn.cos(), -zoom * turn.sin()
    place[:, 1, 0], place[:, 1, 1] = zoom * mirror * turn.sin(), zoom * turn.cos()
    place[:, :, 2] = uniform(-SHIFT, SHIFT, count, 2)
    grid = F.affine_grid(place, list(crops.shape), align_corners=False)
    out = F.grid_sample(crops, grid, padding_mode="border", align_corners=False)
    out = out * uniform(*GAIN, count, 1, 1, 1) + uniform(-OFFSET, OFFSET, count, 1, 1, 1)
    out = out + NOISE * uniform(0, 1, count, 1, 1, 1) * torch.randn(out.shape, generator=generator, device=crops.device)
    blurred = uniform(0, 1, count) < BLURRED
    if blurred.any():
        half = F.interpolate(out[blurred], scale_factor=0.5, mode="area")
        out[blurred] = F.interpolate(half, size=(side, side), mode="bilinear", align_corners=False)
    hidden = uniform(0, 1, count) < HIDDEN
    if hidden.any():
        out[hidden] = _occlude(out[hidden], uniform)
    return out.clamp(0, 1)


def _occlude(crops: torch.Tensor, uniform: Callable[..., torch.Tensor]) -> torch.Tensor:
    count, _, side, _ = crops.shape
    middle_x, middle_y = uniform(0, side, 2, count, 1, 1, 1)
    half_x, half_y = uniform(PATCH[0] * side, PATCH[1] * side, 2, count, 1, 1, 1)
    row = torch.arange(side, device=crops.device).view(1, 1, side, 1)
    column = torch.arange(side, device=crops.device).view(1, 1, 1, side)
    inside = ((column - middle_x).abs() < half_x) & ((row - middle_y).abs() < half_y)
    return torch.where(inside, uniform(0, 1, count, 3, 1, 1), crops)
