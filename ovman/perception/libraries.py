"""The network libraries keep to themselves: nothing is asked of the network, nothing installed, no file of the user's written.

They read these variables once, while they are imported.
"""

from __future__ import annotations

import os
from pathlib import Path

from platformdirs import user_cache_path


def cache() -> Path:
    """The folder of ovman in the user's cache: ~/.cache/ovman, or below XDG_CACHE_HOME, on Linux."""
    return user_cache_path("ovman", appauthor=False)


def keep_to_themselves() -> None:
    """Set what ultralytics and the hub's client read. What the user has set stays, but for the first two."""
    # At its import ultralytics looks up two hosts and writes its settings; when a network is run it reports how it is used.
    os.environ["YOLO_OFFLINE"] = "true"
    # It would install packages that it misses with pip, into an environment that is locked.
    os.environ["YOLO_AUTOINSTALL"] = "false"
    os.environ.setdefault("YOLO_CONFIG_DIR", str(cache()))
    os.environ.setdefault("YOLO_VERBOSE", "false")
    os.environ.setdefault("HF_HUB_DISABLE_TELEMETRY", "1")
