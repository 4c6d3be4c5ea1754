"""The towers of the encoder, from published weights: a network for crops, and sentence-transformers' MiniLM for phrases."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F

from training.public import read_public

IMAGE_MODEL = "tf_efficientnet_lite0"
"""timm's name of the image tower."""
MEAN, DEVIATION = (0.5,) * 3, (0.5,) * 3
"""Normalisation of crops, that of the published weights."""
SIZE = 128
"""Of the embeddings: as many principal components keep what MiniLM knows of household things."""
POOLED, HIDDEN = 1280, 512
"""Features of the image tower before its head, and the width of the head."""
DROPPED, HIDDEN_DROPPED = 0.2, 0.3
"""Shares of features that the training of the head leaves out."""
WIDTH, HEADS, INNER, LAYERS, LONGEST, TINY = 384, 12, 1536, 6, 128, 1e-12
"""Of MiniLM."""


def build_image_tower(published: bool = False) -> Any:
    """Return the image tower with random or with the published weights; its last layer, which gives embeddings, is random.

    `build_head` makes what takes the place of the last layer in the end.
    """
    import timm

    tower = timm.create_model(IMAGE_MODEL, num_classes=SIZE)
    if published:
        own = tower.state_dict()
        given = torch.load(io.BytesIO(read_public("image")), map_location="cpu", weights_only=True)
        # The names differ, the order does not. The last two are the classifier.
        tower.load_state_dict({**own, **dict(list(zip(own, given.values(), strict=True))[:-2])})
    return tower.to(memory_format=torch.channels_last)


def build_head() -> torch.nn.Sequential:
    """Return a random head."""
    return torch.nn.Sequential(
        torch.nn.Dropout(DROPPED),
        torch.nn.Linear(POOLED, HIDDEN),
        torch.nn.ReLU(),
        torch.nn.Dropout(HIDDEN_DROPPED),
        torch.nn.Linear(HIDDEN, SIZE),
    )


def load_image_tower(weights: Path) -> Any:
    """Return the image tower with the weights of `training.encoder`, head included, for evaluation."""
    from safetensors.torch import load_file

    tower = build_image_tower()
    tower.classifier = build_head()
    tower.load_state_dict(load_file(weights))
    return tower.eval()


def fix_padding(tower: Any, side_px: int) -> Any:
    """Return a copy of the image tower for crops of one size. Padding computed for any size takes a tenth of a graph's time."""
    fixed, sizes = deepcopy(tower).eval(), dict[str, int]()
    padded = [(name, part) for name, part in fixed.named_modules() if type(part).__name__ == "Conv2dSame"]
    for name, part in padded:
        part.register_forward_pre_hook(lambda _, given, name=name: sizes.update({name: given[0].shape[-1]}))
    with torch.no_grad():
        fixed(torch.zeros(1, 3, side_px, side_px))
    for name, part in padded:
        (kernel, _), (stride, _), size = part.kernel_size, part.stride, sizes[name]
        more = max((-(-size // stride) - 1) * stride + kernel - size, 0)
        bare = torch.nn.Conv2d(
            part.in_channels, part.out_channels, kernel, stride, groups=part.groups, bias=part.bias is not None
        )
        bare.load_state_dict(part.state_dict())
        parent, _, own = name.rpartition(".")
        around = (more // 2, more - more // 2) * 2
        setattr(fixed.get_submodule(parent), own, torch.nn.Sequential(torch.nn.ZeroPad2d(around), bare))
    return fixed


def prepare(images: np.ndarray) -> torch.Tensor:
    """Return the input of the image tower, (N, 3, S, S), for crops (N, S, S, 3) uint8."""
    return normalise(torch.from_numpy(images).permute(0, 3, 1, 2).float() / 255)


def normalise(images: torch.Tensor) -> torch.Tensor:
    """Normalise images (B, 3, S, S) in [0, 1] for the image tower."""
    mean, deviation = (torch.tensor(v).view(1, 3, 1, 1) for v in (MEAN, DEVIATION))
    return ((images - mean) / deviation).contiguous(memory_format=torch.channels_last)


class _Layer(torch.nn.Module):
    """A layer of BERT."""

    def __init__(self) -> None:
        super().__init__()
        self.mixed, self.joined = torch.nn.Linear(WIDTH, 3 * WIDTH), torch.nn.Linear(WIDTH, WIDTH)
        self.wide, self.narrow = torch.nn.Linear(WIDTH, INNER), torch.nn.Linear(INNER, WIDTH)
        self.first, self.second = (torch.nn.LayerNorm(WIDTH, eps=TINY) for _ in range(2))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        queries, keys, values = self.mixed(x).view(-1, 3, HEADS, WIDTH // HEADS).permute(1, 2, 0, 3)
        weights = (queries @ keys.transpose(1, 2) / (WIDTH // HEADS) ** 0.5).softmax(-1)
        x = self.first(x + self.joined((weights @ values).transpose(0, 1).reshape(-1, WIDTH)))
        y: torch.Tensor = self.second(x + self.narrow(F.gelu(self.wide(x))))
        return y


class TextTower(torch.nn.Module):
    """MiniLM: embeds one phrase, given as numbers (1, N) of word pieces, in (1, SIZE), of any length.

    The mean of the pieces is projected on principal components, which `project` sets; before, it is returned as it is.
    """

    def __init__(self, weights: Mapping[str, torch.Tensor]) -> None:
        """Take the weights of BERT by its names."""
        super().__init__()
        places = weights["embeddings.position_embeddings.weight"] + weights["embeddings.token_type_embeddings.weight"][0]
        self.pieces = torch.nn.Embedding.from_pretrained(weights["embeddings.word_embeddings.weight"])
        self.register_buffer("places", places[:LONGEST])
        self.norm = torch.nn.LayerNorm(WIDTH, eps=TINY)
        self.norm.load_state_dict({kind: weights[f"embeddings.LayerNorm.{kind}"] for kind in ("weight", "bias")})
        self.layers = torch.nn.ModuleList([_Layer() for _ in range(LAYERS)])
        for number, layer in enumerate(self.layers):
            own = {}
            for kind in ("weight", "bias"):
                of = {name: weights[f"encoder.layer.{number}.{name}.{kind}"] for name in _NAMES.values()}
                own[f"mixed.{kind}"] = torch.cat([weights[f"encoder.layer.{number}.{name}.{kind}"] for name in _MIXED])
                own |= {f"{name}.{kind}": of[given] for name, given in _NAMES.items()}
            layer.load_state_dict(own)
        self.last = torch.nn.Identity()

    def project(self, features: torch.Tensor) -> None:
        """Project on the principal components of features (N, WIDTH) from now on; every phrase counts as much."""
        features = F.normalize(features, dim=-1)
        mean = features.mean(0)
        components = torch.linalg.svd(features - mean, full_matrices=False).Vh[:SIZE]
        self.last = torch.nn.Sequential(_Unit(), torch.nn.Linear(WIDTH, SIZE))
        with torch.no_grad():
            self.last[1].weight.copy_(components)
            self.last[1].bias.copy_(-components @ mean)

    def forward(self, pieces: torch.Tensor) -> torch.Tensor:
        """Return the embedding."""
        x = self.norm(self.pieces(pieces[0]) + self.places[: pieces.shape[1]])
        for layer in self.layers:
            x = layer(x)
        found: torch.Tensor = self.last(x.mean(0, keepdim=True))
        return found


class _Unit(torch.nn.Module):
    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return F.normalize(x, dim=-1)


_MIXED = ("attention.self.query", "attention.self.key", "attention.self.value")
_NAMES = {
    "joined": "attention.output.dense",
    "first": "attention.output.LayerNorm",
    "wide": "intermediate.dense",
    "narrow": "output.dense",
    "second": "output.LayerNorm",
}
"""BERT's names of the parts of `_Layer`."""


def build_text_tower() -> tuple[TextTower, Sequence[str]]:
    """Return MiniLM with its published weights, and its word pieces."""
    from safetensors.torch import load

    return TextTower(load(read_public("text"))).eval(), read_public("vocabulary").decode().splitlines()
