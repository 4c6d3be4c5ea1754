"""An engine that stands in for AI2-THOR's Unity build: no GPU, no display, the unmodified ai2thor Controller in front of it."""

import os
import shlex
import sys

__version__ = "0.5.0"
DISPLAY = ":0"
"""A display that nobody opens."""
COMMAND = "OVMAN_ENGINE"
"""Environment variable with the command line of the engine, for processes whose own Python has not what the engine needs."""
MASKS_ONLY = "renderMasksOnly"
"""Key that any action may carry: of the images of its event, only the instance masks are wanted. Colours are four fifths of what
images take. AI2-THOR has no such key."""


def executable() -> str:
    """What to give the Controller as `local_executable_path`.

    The client refuses to start anything while the environment names no DISPLAY; where there is none, this sets one.
    """
    os.environ.setdefault("DISPLAY", DISPLAY)
    return os.environ.get(COMMAND) or f"{shlex.quote(sys.executable)} -m ovman_engine"
