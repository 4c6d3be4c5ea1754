"""Environment variables that keep the network libraries offline: no requests, no installations, no settings files.

The libraries read them once, at import.
"""

from __future__ import annotations

import os
from pathlib import Path

from platformdirs import user_cache_path


def cache() -> Path:
    """The folder of ovman in the user's cache: ~/.cache/ovman, or below XDG_CACHE_HOME, on Linux."""
    return user_cache_path("ovman", appauthor=False)


def keep_to_themselves() -> None:
    """Set the variables of ultralytics and of the hub's client. All but the first two keep a value that the user has set."""
    # At import ultralytics contacts two hosts and writes settings; at inference it reports usage.
    os.environ["YOLO_OFFLINE"] = "true"
    # ultralytics would install missing packages with pip into the locked environment.
    os.environ["YOLO_AUTOINSTALL"] = "false"
    os.environ.setdefault("YOLO_CONFIG_DIR", str(cache()))
    os.environ.setdefault("YOLO_VERBOSE", "false")
    os.environ.setdefault("HF_HUB_DISABLE_TELEMETRY", "1")
