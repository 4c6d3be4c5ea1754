"""Where the files are that the package reads and that are not code: config.yaml, models/ and data/.

In a checkout they lie next to the package. A wheel has them inside it (setup.py).
"""

from __future__ import annotations

from pathlib import Path

PACKAGE = Path(__file__).resolve().parent
INSIDE = PACKAGE / "shipped"
HOME = INSIDE if INSIDE.is_dir() else PACKAGE.parent
"""The folder that has them."""
EMBEDDED = Path("data") / "ovman-embedded-v6"
"""The release, below `HOME`."""
FILES = (
    "config.yaml",
    "config",
    "CITATION.cff",
    "models/detector.onnx",
    "models/encoder.onnx",
    "models/encoder.text.onnx",
    *(f"{EMBEDDED}/{part}" for part in ("README.md", "episodes", "sightings", "metrics", "predictions", "scenes")),
)
"""What a wheel has of them, files and folders."""


def user_cache() -> Path:
    """Return the folder of ovman in the user's cache: ~/.cache/ovman, or below XDG_CACHE_HOME, on Linux."""
    from platformdirs import user_cache_path  # setup.py reads this module before the package is installed

    return user_cache_path("ovman", appauthor=False)
