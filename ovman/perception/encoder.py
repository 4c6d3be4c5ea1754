"""Crops and noun phrases in one space: the image and text towers of an open_clip model."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ovman.perception.graph import Graph, exported
from ovman.perception.network_cache import NetworkCache
from ovman.perception.weights import WeightsError, fitting, located, state

KEY = "perception.encoder"
TOGETHER = 64
"""Batch size of crops and phrases."""
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


@dataclass(frozen=True, slots=True)
class EncoderFacts:
    """What preparing crops and reading embeddings needs of the towers.

    side_px: of the crops; size: K of the embeddings; mean and deviation (3,): normalisation of pictures.
    """

    side_px: int
    size: int
    mean: tuple[float, ...]
    deviation: tuple[float, ...]

    @staticmethod
    def of(network: Any, of: Architecture) -> EncoderFacts:
        """The facts of a network of an architecture."""
        side = network.visual.image_size
        return EncoderFacts(int(side if isinstance(side, int) else side[0]), int(of.towers["embed_dim"]), of.mean, of.deviation)


class Encoder:
    """The image and text towers of an open_clip model, with their preprocessing.

    load: returns the towers and their architecture; on a processor it is called only for a graph of the image tower or
    embeddings of phrases that the cache does not have. side_px: of the crops; size: K of the embeddings.
    """

    def __init__(
        self, load: Callable[[], tuple[Any, Architecture]], device: str = "cpu", kept: NetworkCache | None = None
    ) -> None:
        import torch

        self._load, self._device, self._kept = load, device, kept or NetworkCache(None)
        facts = json.loads(self._kept.content("facts.json", lambda: json.dumps(asdict(EncoderFacts.of(*self._towers))).encode()))
        self.side_px, self.size = facts["side_px"], facts["size"]
        self._mean, self._deviation = (
            torch.tensor(facts[name], device=device).view(1, 3, 1, 1) for name in ("mean", "deviation")
        )

    @cached_property
    def _towers(self) -> tuple[Any, Architecture]:
        network, of = self._load()
        return network.to(self._device).float().eval(), of

    @cached_property
    def _tokens(self) -> Callable[[list[str]], Any]:
        from open_clip.tokenizer import SimpleTokenizer

        length = self._towers[1].towers["text_cfg"].get("context_length", 77)
        tokenizer: Callable[[list[str]], Any] = SimpleTokenizer(context_length=length)
        return tokenizer

    @cached_property
    def look(self) -> Callable[[Any], Any]:
        """The image tower as it runs, for crops (N, 3, side_px, side_px); on a processor a graph."""
        if self._device != "cpu":
            tower: Callable[[Any], Any] = self._towers[0].encode_image
            return tower
        shape = (0, 3, self.side_px, self.side_px)
        graph = Graph(self._kept.content("images.onnx", lambda: exported(self._towers[0].visual, shape)))
        return lambda crops: graph(crops)[0]

    def images(self, crops: np.ndarray) -> np.ndarray:
        """Unit embeddings (N, K) float32 of crops (N, side_px, side_px, 3) uint8 RGB."""
        import torch

        def prepared(part: np.ndarray) -> Any:
            tensor = torch.from_numpy(part).to(self._device).permute(0, 3, 1, 2).float().div_(255)
            return tensor.sub_(self._mean).div_(self._deviation)

        parts = [crops[start : start + TOGETHER] for start in range(0, len(crops), TOGETHER)]
        return self._embedded(lambda part: self.look(prepared(part)), parts)

    def texts(self, phrases: Sequence[str]) -> np.ndarray:
        """Unit embeddings (N, K) float32 of noun phrases."""
        asked = hashlib.sha256(json.dumps(list(phrases)).encode()).hexdigest()
        found = self._kept.content(f"{asked}.phrases", lambda: self._read(phrases).tobytes())
        return np.frombuffer(found, np.float32).reshape(len(phrases), self.size).copy()

    def _read(self, phrases: Sequence[str]) -> np.ndarray:
        read = self._towers[0].encode_text
        parts = [list(phrases[start : start + TOGETHER]) for start in range(0, len(phrases), TOGETHER)]
        return self._embedded(lambda part: read(self._tokens(part).to(self._device)), parts)

    def _embedded(self, tower: Callable[[Any], Any], parts: Sequence[Any]) -> np.ndarray:
        import torch

        with torch.inference_mode():
            found = [torch.nn.functional.normalize(tower(part).float(), dim=-1).cpu().numpy() for part in parts]
        return np.concatenate([np.zeros((0, self.size), np.float32), *found])


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
