"""Image and text towers of open_clip: what loads them, and how they read phrases. Needs the extra `networks`."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ovman.perception.encoder import KEY, TOGETHER, EncoderFacts
from ovman.perception.weights import WeightsError, fitting, located, state

TOWERS = ("embed_dim", "vision_cfg", "text_cfg")


@dataclass(frozen=True, slots=True)
class Architecture:
    """Towers of an open_clip model.

    name: for messages; towers: open_clip's configuration; mean and deviation (3,): normalisation of pictures.
    """

    name: str
    towers: Mapping[str, Any]
    mean: tuple[float, ...]
    deviation: tuple[float, ...]


def architecture(model: str, tag: str = "") -> Architecture:
    """The towers that a name of open_clip or a configuration file (.json) describes; `tag` names released weights, if any.

    WeightsError for an unknown model, an unreadable file, and towers that are not CLIP's own.
    """
    from open_clip.constants import OPENAI_DATASET_MEAN, OPENAI_DATASET_STD
    from open_clip.factory import get_model_config
    from open_clip.pretrained import get_pretrained_cfg

    path = located(model)
    if path is None:
        towers, released = get_model_config(model), get_pretrained_cfg(model, tag)
        if towers is None:
            raise WeightsError(f"{KEY}.model is {model}, which is no model of open_clip; name one that it has or a file (.json)")
    else:
        towers, released = _configuration(path, model), {}
    foreign = {*towers} - {*TOWERS, "quick_gelu"} | {name for name in towers["text_cfg"] if name.startswith("hf_")}
    if foreign:
        what = ", ".join(sorted(foreign))
        raise WeightsError(f"{KEY}.model is {model}, whose {what} is not known here; name a model with CLIP's own towers")
    return Architecture(
        model,
        dict(towers) | {"quick_gelu": released.get("quick_gelu", towers.get("quick_gelu", False))},
        tuple(released.get("mean", OPENAI_DATASET_MEAN)),
        tuple(released.get("std", OPENAI_DATASET_STD)),
    )


def empty_network(of: Architecture) -> Any:
    """The towers with random weights."""
    from open_clip.model import CLIP

    return CLIP(**deepcopy(dict(of.towers)))


def network_of(weights: Path, of: Architecture, trust_pickles: bool = False) -> Any:
    """The towers of a file of weights. WeightsError where they do not fit."""
    tensors = {name: value for name, value in state(weights, trust_pickles, KEY).items() if name != "attn_mask"}
    return fitting(empty_network(of), tensors, weights.name, KEY)


def facts_of(network: Any, of: Architecture) -> EncoderFacts:
    """The facts of a network of an architecture."""
    side = network.visual.image_size
    return EncoderFacts(int(side if isinstance(side, int) else side[0]), int(of.towers["embed_dim"]), of.mean, of.deviation)


def texts(network: Any, of: Architecture, phrases: Sequence[str], device: str = "cpu") -> np.ndarray:
    """Unit embeddings (N, K) float32 of phrases by the text tower of a network on its device."""
    import torch
    from open_clip.tokenizer import SimpleTokenizer

    tokens: Callable[[list[str]], Any] = SimpleTokenizer(context_length=of.towers["text_cfg"].get("context_length", 77))
    parts = [list(phrases[start : start + TOGETHER]) for start in range(0, len(phrases), TOGETHER)]
    with torch.inference_mode():
        read = [network.encode_text(tokens(part).to(device)).float() for part in parts]
        found = [torch.nn.functional.normalize(part, dim=-1).cpu().numpy() for part in read]
    return np.concatenate([np.zeros((0, int(of.towers["embed_dim"])), np.float32), *found])


def _configuration(path: Path, name: str) -> Mapping[str, Any]:
    try:
        towers = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise WeightsError(f"{KEY}.model: {name}: {error.strerror}; name a model of open_clip or an existing file") from None
    except ValueError as error:
        raise WeightsError(f"{KEY}.model: {name} is not JSON ({error}); write an object with {', '.join(TOWERS)}") from None
    kinds = (int, Mapping, Mapping)
    if not isinstance(towers, Mapping) or not all(isinstance(towers.get(k), kind) for k, kind in zip(TOWERS, kinds, strict=True)):
        raise WeightsError(f"{KEY}.model: {name} has no towers; write an object with {', '.join(TOWERS)}")
    return towers
