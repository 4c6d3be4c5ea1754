"""Train the small image and text towers on crops with captions, from random or from given weights.

A contrastive loss in both directions takes every right noun of a crop, and every right crop of a noun, as a target. For a part of
the batch a second loss does so for captions with an attribute ("a blue chair").
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from open_clip.constants import OPENAI_DATASET_MEAN, OPENAI_DATASET_STD

from ovman.language.vocabulary import SYNONYMS, nouns
from ovman.perception.pytorch import Architecture, empty_towers
from ovman.settings import Settings
from training.captions import TEMPLATES, WORDS, attributes, vocabulary
from training.crops import Crops
from training.trainer import reduced_precision

MODEL: Mapping[str, Any] = {
    "embed_dim": 128,
    "vision_cfg": {"image_size": 64, "layers": [2, 2, 2, 2], "width": 24, "patch_size": None},
    "text_cfg": {"context_length": 16, "vocab_size": 49408, "width": 64, "heads": 2, "layers": 3},
}
"""open_clip's configuration: an image tower for crops of 64 px and a small text tower, 7.2 M parameters."""
WARM_STEPS, BETAS, CLIPPED, MEMORY = 200, (0.9, 0.98), 1.0, 0.998
"""MEMORY: decay of the moving average of the weights; the average is saved."""
SCALES, SCALED_AFTER = (14.0, 100.0), 0.6
"""Logit scale, raised over this share of the steps to CLIP's own, so that a similarity margin such as delta_g is as wide for
these towers as for those of the paper."""
REVERSE, ATTRIBUTE, ATTRIBUTED = 0.3, 0.3, 96
"""Weights of the two minor losses, and the number of crops of a batch in the second."""
SMALL_PX, SMALL_SHARE = 600, 0.3
"""Crops of masks below SMALL_PX are sampled less often, down to this share."""
CHUNK = 512
TOWERS = Architecture("encoder.json", MODEL, OPENAI_DATASET_MEAN, OPENAI_DATASET_STD)
"""The architecture as `ovman.perception.pytorch` reads it from a file."""
MIRRORED, BLURRED, HIDDEN = 0.5, 0.25, 0.3
"""Shares of mirrored, blurred and partly occluded crops."""
ZOOM, SHIFT, TURN_RAD = (0.75, 1.15), 0.12, 0.06
GAIN, OFFSET, NOISE = (0.7, 1.3), 0.08, 0.03
PATCH = (0.05, 0.22)
"""Half sides of an occluder as a share of the crop's side."""


@dataclass(frozen=True, slots=True)
class RetrievalRates:
    """Retrieval among the categories of a scene: share of crops whose category is first, or among the first five."""

    top_1: float
    top_5: float
    synonyms_top_1: float
    """top_1 with a synonym of the right category in place of its own noun."""


class TrainingSet:
    """Crops, their right nouns and attributes, and the tokens of all captions."""

    def __init__(self, crops: Crops, categories: Sequence[str]) -> None:
        from open_clip.tokenizer import SimpleTokenizer

        tokenise = SimpleTokenizer(context_length=MODEL["text_cfg"]["context_length"])
        number = {category: k for k, category in enumerate(categories)}
        self.images = torch.from_numpy(crops.images)
        self.labels = torch.tensor([number[category] for category in crops.types.tolist()])
        words = attributes(crops.types, crops.materials, crops.colours, crops.sizes_m)
        self.words = torch.from_numpy(words)
        names, right = vocabulary(categories)
        self.nouns, self.right = names, torch.from_numpy(right)
        self.plain = torch.stack([tokenise([template.format(name) for name in names]) for template in TEMPLATES])
        self.attributed = torch.stack([tokenise([f"a {word} {name}" for name in names]) for word in WORDS])
        counts = np.bincount(self.labels.numpy(), minlength=len(categories))
        small = np.clip(crops.pixels / SMALL_PX, SMALL_SHARE, 1.0)
        self.chance = torch.from_numpy(small / np.sqrt(counts[self.labels.numpy()])).double()


def build_towers() -> Any:
    """Return the towers with random weights."""
    return empty_towers(TOWERS)


def normalise(images: torch.Tensor) -> torch.Tensor:
    """Normalise images (B, 3, S, S) in [0, 1] for the image tower."""
    mean, deviation = (torch.tensor(v, device=images.device).view(1, 3, 1, 1) for v in (TOWERS.mean, TOWERS.deviation))
    return ((images - mean) / deviation).contiguous(memory_format=torch.channels_last)


def run(
    taught: Sequence[Path],
    held_out: Mapping[str, Sequence[Path]],
    settings: Settings,
    start: Path | None,
    weights: Path,
    curve: Path,
) -> None:
    """Train on the crops of the files `taught`, from the weights `start` if given.

    held_out: files of crops by kind of mask, "true" and "detected", for evaluation only. Writes weights
    (.safetensors, half precision) and the curve (JSON lines).
    """
    from safetensors.torch import load_file, save_file

    torch.set_num_threads(1)
    training, seed = settings.training.encoder, settings.training.seed
    steps, peak = (
        (training.steps, training.learning_rate) if start is None else (training.further_steps, training.further_learning_rate)
    )
    torch.manual_seed(seed)
    generator = torch.Generator().manual_seed(seed)
    crops = Crops.join([Crops.read(path) for path in taught])
    shown = {name: [Crops.read(path) for path in files] for name, files in held_out.items()}
    categories = sorted(
        {*SYNONYMS, *crops.types.tolist(), *(t for parts in shown.values() for c in parts for t in c.types.tolist())}
    )
    lessons = TrainingSet(crops, categories)
    model = build_towers()
    if start is not None:
        model.load_state_dict({name: value.float() for name, value in load_file(start).items()}, strict=False)
    model.logit_scale.requires_grad_(False)
    model.visual.to(memory_format=torch.channels_last)
    average = {name: value.detach().clone().float() for name, value in model.state_dict().items()}
    optimiser = _optimiser(model, peak, training.weight_decay)
    parameters = sum(p.numel() for p in model.parameters())
    print(f"{len(crops.types)} crops, {len(lessons.nouns)} nouns, {parameters / 1e6:.2f} M parameters", flush=True)
    curve.write_text("")
    began = time.monotonic()
    for step in range(1, steps + 1):
        for group in optimiser.param_groups:
            group["lr"] = peak * min(1.0, step / WARM_STEPS) * 0.5 * (1 + math.cos(math.pi * step / steps))
        batch = torch.multinomial(lessons.chance, training.batch, replacement=True, generator=generator)
        rise = 1.0 if start is not None else min(1.0, step / (SCALED_AFTER * steps))
        with torch.no_grad():
            model.logit_scale.fill_(math.log(SCALES[0]) + rise * math.log(SCALES[1] / SCALES[0]))
        optimiser.zero_grad(set_to_none=True)
        loss = _loss(model, lessons, batch, generator)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), CLIPPED)
        optimiser.step()
        keep = min(MEMORY, step / (step + 10))
        with torch.no_grad():
            for name, value in model.state_dict().items():
                average[name].lerp_(value.float(), 1 - keep)
        if step % training.look_every == 0 or step == steps:
            kept = build_towers()
            kept.load_state_dict({name: value.to(kept.state_dict()[name].dtype) for name, value in average.items()})
            save_file({k: v.half().contiguous() for k, v in kept.state_dict().items() if k != "attn_mask"}, weights)
            looks = {name: measure_retrieval(kept, parts) for name, parts in shown.items()}
            record = {
                "step": step,
                "minutes": round((time.monotonic() - began) / 60, 1),
                "loss": round(loss.item(), 4),
                **{
                    name: {"top1": round(r.top_1, 4), "top5": round(r.top_5, 4), "synonyms_top1": round(r.synonyms_top_1, 4)}
                    for name, r in looks.items()
                },
            }
            line = json.dumps(record)
            with curve.open("a", encoding="utf-8") as file:
                file.write(line + "\n")
            print(line, flush=True)


def _optimiser(model: Any, peak: float, weight_decay: float) -> torch.optim.Optimizer:
    learned = [p for p in model.parameters() if p.requires_grad]
    decayed = [p for p in learned if p.ndim >= 2]
    plain = [p for p in learned if p.ndim < 2]
    groups = [{"params": decayed, "weight_decay": weight_decay}, {"params": plain, "weight_decay": 0.0}]
    return torch.optim.AdamW(groups, lr=peak, betas=BETAS)


def _loss(model: Any, lessons: TrainingSet, batch: torch.Tensor, generator: torch.Generator) -> torch.Tensor:
    images = augment(lessons.images[batch].permute(0, 3, 1, 2).float() / 255, generator)
    labels = lessons.labels[batch]
    with reduced_precision("cpu"):
        seen = model.encode_image(normalise(images))
    seen = F.normalize(seen.float(), dim=-1)
    scale = model.logit_scale.exp()
    template = torch.randint(len(TEMPLATES), (len(lessons.nouns),), generator=generator)
    said = F.normalize(model.encode_text(lessons.plain[template, torch.arange(len(lessons.nouns))]), dim=-1)
    logits = scale * seen @ said.T
    right = lessons.right[:, labels].T.float()
    loss = -(right / right.sum(1, keepdim=True) * logits.log_softmax(1)).sum(1).mean()
    there = right.sum(0) > 0
    loss = loss - REVERSE * (right[:, there] / right[:, there].sum(0) * logits[:, there].log_softmax(0)).sum(0).mean()
    few = slice(0, ATTRIBUTED)
    words = lessons.words[batch[few]]
    word = torch.multinomial(words.float(), 1, generator=generator)[:, 0]
    noun = torch.multinomial(right[few], 1, generator=generator)[:, 0]
    said = F.normalize(model.encode_text(lessons.attributed[word, noun]), dim=-1)
    true = (lessons.right[noun][:, labels[few]].T & words[:, word]).float()
    own = (scale * seen[few] @ said.T).log_softmax(1)
    total: torch.Tensor = loss - ATTRIBUTE * (true / true.sum(1, keepdim=True) * own).sum(1).mean()
    return total


@torch.no_grad()
def measure_retrieval(model: Any, scenes: Sequence[Crops]) -> RetrievalRates:
    """Measure retrieval of the right category among all categories of a scene's crops, over the crops of all scenes.

    A synonym that several categories share is right for each of them.
    """
    from open_clip.tokenizer import SimpleTokenizer

    model.eval()
    tokenise = SimpleTokenizer(context_length=MODEL["text_cfg"]["context_length"])
    first = fifth = total = 0
    synonym_first = synonym_total = 0.0
    for crops in scenes:
        if not len(crops.types):
            continue
        categories = np.unique(crops.types).tolist()
        own = _embed_texts(model, tokenise, [nouns(category)[0] for category in categories])
        seen = torch.cat([_embed_images(model, crops.images[k : k + CHUNK]) for k in range(0, len(crops.images), CHUNK)])
        labels = torch.tensor([categories.index(category) for category in crops.types.tolist()])
        similar = seen @ own.T
        rank = (similar > similar.gather(1, labels[:, None])).sum(1)
        first, fifth, total = first + int((rank < 1).sum()), fifth + int((rank < 5).sum()), total + len(rank)
        for number, category in enumerate(categories):
            here = labels == number
            for synonym in nouns(category)[1:]:
                others = [k for k, c in enumerate(categories) if k != number and synonym not in nouns(c)]
                said = _embed_texts(model, tokenise, [synonym])[0]
                best = similar[here][:, others].max(dim=1).values if others else torch.full((int(here.sum()),), -1.0)
                synonym_first += float((seen[here] @ said > best).sum()) / len(nouns(category)[1:])
            synonym_total += float(here.sum()) if len(nouns(category)) > 1 else 0.0
    return RetrievalRates(first / max(total, 1), fifth / max(total, 1), synonym_first / max(synonym_total, 1.0))


def _embed_texts(model: Any, tokenise: Any, names: Sequence[str]) -> torch.Tensor:
    return F.normalize(model.encode_text(tokenise(list(names))), dim=-1)


def _embed_images(model: Any, images: np.ndarray) -> torch.Tensor:
    tensor = torch.from_numpy(images).permute(0, 3, 1, 2).float() / 255
    return F.normalize(model.encode_image(normalise(tensor)), dim=-1)


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
