"""Weights: graphs, files of tensors, or releases that are downloaded. A pickle is opened only if the user trusts it.

Opening a pickle can run code of its author; a .onnx or a .safetensors file cannot. Network libraries are imported when a file is
opened, so that the Snakefile can ask which weights are files.
"""

from __future__ import annotations

import contextlib
import difflib
import hashlib
import importlib.util
import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ovman.shipped import HOME, user_cache

if TYPE_CHECKING:
    from ovman.settings.networks import Perception

# The network libraries read these variables once, at import.
# At import ultralytics contacts two hosts and writes settings; at inference it reports usage.
os.environ["YOLO_OFFLINE"] = "true"
# ultralytics would install missing packages with pip into the locked environment.
os.environ["YOLO_AUTOINSTALL"] = "false"
os.environ.setdefault("YOLO_CONFIG_DIR", str(user_cache()))
os.environ.setdefault("YOLO_VERBOSE", "false")
os.environ.setdefault("HF_HUB_DISABLE_TELEMETRY", "1")

SAFE = ".safetensors"
GRAPH = ".onnx"
TEXTS = ".text.onnx"
"""How the file of the text tower of an image tower's graph ends."""
FILES = frozenset({SAFE, GRAPH, ".json"})
EXTRA = ("torch", "torchvision", "ultralytics", "open_clip", "onnx", "safetensors")
"""The modules of the extra `networks`, which opens weights that are not a graph."""
ASSETS_RELEASE = "v8.4.0"
"""The release of ultralytics' assets that weights are taken from."""
SHA256: Mapping[str, str] = {"yolov8m-seg.pt": "51fa7e5ef385efa6d5b1d8e31b73399be6ed5d7ca71bda4bd4b2794bb445c4f4"}
"""Digests of files of that release."""


class WeightsError(ValueError):
    """Weights that cannot be used; one line: the setting, the problem, and the remedy."""

    says_all = True


def located(name: str) -> Path | None:
    """Return the file that a setting names, relative to `ovman.shipped.HOME` unless absolute; None for a released name.

    A name is that of a file if it has a folder in it ("./mine.pt") or ends in .onnx, .safetensors or .json.
    """
    path = Path(name)
    return HOME / path if len(path.parts) > 1 or name.startswith("./") or path.suffix in FILES else None


def files_of(perception: Perception) -> list[Path]:
    """Return the files of the networks of the settings, and the folder of those that were downloaded."""
    detector, encoder = perception.detector, perception.encoder
    named = (detector.weights, detector.architecture, encoder.weights, encoder.model)
    files = [path for name in named if (path := located(name)) is not None]
    return [*files, *map(texts_of, files), user_cache() / ASSETS_RELEASE]


def is_graph(name: str) -> bool:
    """Return whether a setting names a graph, which runs without the extra `networks`."""
    return name.endswith(GRAPH)


def texts_of(graph: Path) -> Path:
    """Return the file of the text tower of the graph of an image tower: encoder.text.onnx of encoder.onnx."""
    return graph.with_suffix(TEXTS)


def need_networks(name: str, key: str) -> None:
    """Raise WeightsError if a library that opens the weights `name` is not installed. Imports none."""
    missing = [module for module in EXTRA if importlib.util.find_spec(module) is None]
    if missing:
        raise WeightsError(
            f"{key}.weights is {name}, which needs {', '.join(missing)}; in a checkout of OVMAN: pip install '.[networks]', "
            f"or name a graph ({GRAPH})"
        )


def sha256(path: Path) -> str:
    """Return the hexadecimal SHA-256 of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def detector_file(name: str, trust_pickles: bool, expected: str = "", key: str = "perception.detector") -> Path:
    """Return the file of a detector's weights: a file, or one of ultralytics' assets, which is downloaded once.

    expected: SHA-256 that the file must have, "" if unknown. Raises WeightsError.
    """
    path = located(name)
    if path is None and not name.endswith(".pt"):
        raise WeightsError(
            f"{key}.weights is {name}; it must be a file (.onnx, .safetensors, or .pt with its folder) or an asset's name (.pt)"
        )
    _refuse_pickle((path or Path(name)).name, trust_pickles, key)
    return _check(_download_asset(name, key) if path is None else path, name, expected, key)


def encoder_file(model: str, name: str, trust_pickles: bool, expected: str = "", key: str = "perception.encoder") -> Path:
    """Return the file of an encoder's weights: a file, or open_clip's tag of released ones of `model`, downloaded once.

    expected: SHA-256 that the file must have, "" if unknown. Raises WeightsError.
    """
    path = located(name)
    if path is not None:
        _refuse_pickle(path.name, trust_pickles, key)
    return _check(_download_tagged(model, name, key) if path is None else path, name, expected, key)


def read_state(path: Path, trust_pickles: bool, key: str) -> dict[str, Any]:
    """Read the tensors of a file by their names: of .safetensors, or of the network or the tensors of a trusted pickle.

    Raises:
        WeightsError: The pickle is not trusted, or the file holds something else.
    """
    _refuse_pickle(path.name, trust_pickles, key)
    try:
        if path.suffix == SAFE:
            from safetensors.torch import load_file

            return load_file(path)
        import torch

        held = torch.load(path, map_location="cpu", weights_only=False)
    except Exception as error:
        raise WeightsError(
            f"{key}.weights: {path.name} cannot be opened ({_first_line(error)}); give a whole file of weights"
        ) from None
    for name in ("ema", "model", "state_dict"):  # ultralytics' trainer keeps a moving average, the better network
        if isinstance(held, Mapping) and held.get(name) is not None:
            held = held[name]
            break
    if hasattr(held, "state_dict"):
        held = held.state_dict()
    if not isinstance(held, Mapping) or not all(hasattr(value, "shape") for value in held.values()):
        raise WeightsError(f"{key}.weights: {path.name} has neither a network nor tensors by name; give a file of weights")
    return dict(held)


def fit_weights(network: Any, tensors: Mapping[str, Any], name: str, key: str) -> Any:
    """Load tensors into a network, in single precision. Raises WeightsError if they are another network's."""
    try:
        network.load_state_dict({k: v.float() if v.is_floating_point() else v for k, v in tensors.items()})
    except RuntimeError as error:
        setting, why = "architecture" if key.endswith("detector") else "model", _first_line(error)
        raise WeightsError(f"{key}.weights: {name} does not fit {key}.{setting} ({why}); name the one it was made for") from None
    return network


def _refuse_pickle(name: str, trust_pickles: bool, key: str) -> None:
    if not name.endswith((SAFE, GRAPH)) and not trust_pickles:
        raise WeightsError(
            f"{key}.weights: {name} is a pickle, which can run code of its author when it is opened; "
            f"set perception.trust_pickles to true if you trust it, or give a {SAFE} or {GRAPH} file"
        )


def _check(path: Path, name: str, expected: str, key: str) -> Path:
    if not path.is_file():
        raise WeightsError(
            f"{key}.weights: the file {name} is missing; "
            "`make models` makes the default's, `python -m training.export` a graph of weights, or name another"
        )
    expected = expected or (SHA256.get(name, "") if located(name) is None else "")
    if expected and (found := sha256(path)) != expected:
        raise WeightsError(f"{key}.weights: the SHA-256 of {path} is {found}, not {expected}; remove the file and get it again")
    return path


def _download_asset(name: str, key: str) -> Path:
    """Return one of ultralytics' assets, kept in the user's cache."""
    kept = user_cache() / ASSETS_RELEASE / name
    if not kept.is_file():
        need_networks(name, key)
        from ultralytics.utils.downloads import attempt_download_asset

        kept.parent.mkdir(parents=True, exist_ok=True)
        reason = "the release has no such asset"
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                attempt_download_asset(kept, release=ASSETS_RELEASE, progress=False)
        except Exception as error:
            reason = _first_line(error)
        if not kept.is_file():
            raise _undelivered(name, key, reason)
    return kept


def _download_tagged(model: str, tag: str, key: str) -> Path:
    """Return released weights of a model of open_clip, as .safetensors, kept in the hub's own cache."""
    need_networks(tag, key)
    from open_clip.pretrained import download_pretrained_from_hf, get_pretrained_cfg, list_pretrained_tags_by_model

    if located(model) is not None:
        raise WeightsError(f"{key}.weights is {tag}; a model of your own ({model}) needs a file of weights")
    found = get_pretrained_cfg(model, tag)
    if not found:
        tags = list_pretrained_tags_by_model(model)
        near = ", ".join(difflib.get_close_matches(tag, tags, n=3, cutoff=0.0))
        remedy = f"the nearest are {near}" if tags else f"open_clip does not have {model}, name a model that it has"
        raise WeightsError(f"{key}.weights is {tag}, which is not a tag of {model}; {remedy}")
    repository = found.get("hf_hub", "")
    if not repository.endswith("/"):
        raise WeightsError(f"{key}.weights: {tag} of {model} was not released as {SAFE}; give a file of weights")
    try:
        return Path(download_pretrained_from_hf(repository.rstrip("/"), filename=f"open_clip_model{SAFE}"))
    except Exception as error:
        raise _undelivered(f"open_clip_model{SAFE} of {model} {tag}", key, _first_line(error)) from None


def _undelivered(name: str, key: str, reason: str) -> WeightsError:
    return WeightsError(
        f"{key}.weights: {name} could not be downloaded ({reason}); "
        f"download it where there is a connection and give the file, with its folder, as {key}.weights"
    )


def _first_line(error: Exception) -> str:
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= 160 else text[:157] + "..."
