"""Networks of ultralytics and open_clip, which PyTorch runs. Needs the extra `networks`."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ovman.perception import detector, encoder
from ovman.perception.detector import AT_MOST, DetectorFacts
from ovman.perception.encoder import TOGETHER, EncoderFacts
from ovman.perception.graph import Network
from ovman.perception.weights import WeightsError, fit_weights, located, read_state

_SCORES = re.compile(r"model\.\d+\.cv3\.0\.2\.bias")
"""The bias of the class scores; its length is the number of classes."""
_MOST = 300
"""Least number of boxes that a network which suppresses overlaps itself gives, as in ultralytics."""
TOWERS = ("embed_dim", "vision_cfg", "text_cfg")


def run_by_torch(network: Any, device: str) -> Network:
    """Return a network as a function of arrays. Its numbers do not depend on what was run before.

    Raises:
        WeightsError: The device is a GPU and there is none.
    """
    import torch

    torch.set_num_threads(1)
    torch.backends.cudnn.benchmark = False
    if device != "cpu" and not torch.cuda.is_available():
        raise WeightsError("perception.device is cuda, but torch finds no GPU; set it to cpu")
    network = network.to(device).eval()

    def run(pictures: np.ndarray) -> tuple[np.ndarray, ...]:
        with torch.inference_mode():
            given = network(torch.from_numpy(pictures).to(device))
        return tuple(one.float().cpu().numpy() for one in (given if isinstance(given, tuple | list) else (given,)))

    return run


def empty_detector(architecture: str, classes: int = 1) -> Any:
    """Return a network of an architecture of ultralytics, such as "yolov8n-seg", with random weights. Raises WeightsError."""
    from ultralytics.nn.tasks import SegmentationModel

    try:
        build: Callable[..., Any] = SegmentationModel  # ultralytics has no types
        return build(f"{architecture}.yaml", nc=classes, verbose=False)
    except (FileNotFoundError, KeyError, AttributeError):
        raise WeightsError(
            f"{detector.KEY}.architecture is {architecture}, which ultralytics does not have; yolov8n-seg is one"
        ) from None


def load_detector(weights: Path, architecture: str, trust_pickles: bool = False) -> Any:
    """Load a detector with the weights of a file, which determine its number of classes. Raises WeightsError."""
    tensors = read_state(weights, trust_pickles, detector.KEY)
    scores = [value for name, value in tensors.items() if _SCORES.fullmatch(name)]
    return fit_weights(empty_detector(architecture, len(scores[0]) if scores else 1), tensors, weights.name, detector.KEY)


def detector_facts(network: Any) -> DetectorFacts:
    """Return the facts of a detector."""
    end2end = bool(getattr(network, "end2end", False))
    return DetectorFacts(max(int(network.stride.max()), 32), end2end, int(network.model[-1].nc))


def fuse_detector(network: Any) -> Any:
    """Return a copy of a detector as it runs: layers fused, for frames of any size, with the outputs that `Detector` reads."""
    import torch

    class Boxes(torch.nn.Module):
        def __init__(self, network: Any) -> None:
            super().__init__()
            self.network = network

        def forward(self, pictures: Any) -> Any:
            given = self.network(pictures)
            return given[0] if isinstance(given[0], tuple) else given[:2]

    fused = deepcopy(network).float().eval().fuse(verbose=False)
    if detector_facts(fused).end2end:
        fused.set_head_attr(max_det=max(AT_MOST, _MOST), agnostic_nms=True)
    fused.model[-1].dynamic = True  # places of the boxes are computed for each frame, not kept from the first one
    return Boxes(fused).eval()


@dataclass(frozen=True, slots=True)
class Architecture:
    """Towers of an open_clip model.

    name: for messages; towers: open_clip's configuration; mean and deviation (3,): normalisation of pictures.
    """

    name: str
    towers: Mapping[str, Any]
    mean: tuple[float, ...]
    deviation: tuple[float, ...]


def read_architecture(model: str, tag: str = "") -> Architecture:
    """Return the towers that a name of open_clip or a configuration file (.json) describes.

    tag: Name of released weights, whose normalisation counts. WeightsError for a model that is unknown, a file that is not
    readable, and towers that are not CLIP's own.
    """
    from open_clip.constants import OPENAI_DATASET_MEAN, OPENAI_DATASET_STD
    from open_clip.factory import get_model_config
    from open_clip.pretrained import get_pretrained_cfg

    path = located(model)
    if path is None:
        towers, released = get_model_config(model), get_pretrained_cfg(model, tag)
        if towers is None:
            raise WeightsError(f"{encoder.KEY}.model is {model}, which open_clip does not have; name one that it has or a .json")
    else:
        towers, released = _read_configuration(path, model), {}
    foreign = {*towers} - {*TOWERS, "quick_gelu"} | {name for name in towers["text_cfg"] if name.startswith("hf_")}
    if foreign:
        names = ", ".join(sorted(foreign))
        raise WeightsError(f"{encoder.KEY}.model is {model}, whose {names} is unknown here; name a model with CLIP's own towers")
    return Architecture(
        model,
        dict(towers) | {"quick_gelu": released.get("quick_gelu", towers.get("quick_gelu", False))},
        tuple(released.get("mean", OPENAI_DATASET_MEAN)),
        tuple(released.get("std", OPENAI_DATASET_STD)),
    )


def empty_towers(of: Architecture) -> Any:
    """Return the towers with random weights."""
    from open_clip.model import CLIP

    return CLIP(**deepcopy(dict(of.towers)))


def load_towers(weights: Path, of: Architecture, trust_pickles: bool = False) -> Any:
    """Load the towers of a file of weights. Raises WeightsError if they do not fit."""
    tensors = {name: value for name, value in read_state(weights, trust_pickles, encoder.KEY).items() if name != "attn_mask"}
    return fit_weights(empty_towers(of), tensors, weights.name, encoder.KEY)


def towers_facts(network: Any, of: Architecture) -> EncoderFacts:
    """Return the facts of towers of an architecture."""
    side = network.visual.image_size
    return EncoderFacts(int(side if isinstance(side, int) else side[0]), int(of.towers["embed_dim"]), of.mean, of.deviation)


def embed_texts(network: Any, of: Architecture, phrases: Sequence[str], device: str = "cpu") -> np.ndarray:
    """Return unit embeddings (N, K) float32 of phrases by the text tower of a network on its device."""
    import torch
    from open_clip.tokenizer import SimpleTokenizer

    tokens: Callable[[list[str]], Any] = SimpleTokenizer(context_length=of.towers["text_cfg"].get("context_length", 77))
    parts = [list(phrases[start : start + TOGETHER]) for start in range(0, len(phrases), TOGETHER)]
    with torch.inference_mode():
        read = [network.encode_text(tokens(part).to(device)).float() for part in parts]
        found = [torch.nn.functional.normalize(part, dim=-1).cpu().numpy() for part in read]
    return np.concatenate([np.zeros((0, int(of.towers["embed_dim"])), np.float32), *found])


def _read_configuration(path: Path, name: str) -> Mapping[str, Any]:
    try:
        towers = json.loads(path.read_text(encoding="utf-8"))
        is_whole = all(isinstance(towers[key], kind) for key, kind in zip(TOWERS, (int, dict, dict), strict=True))
    except (OSError, ValueError, LookupError, TypeError):
        is_whole = False
    if not is_whole:
        raise WeightsError(f"{encoder.KEY}.model: {name} has no towers; write a JSON object with {', '.join(TOWERS)}")
    return dict(towers)
