"""An engine that stands in for AI2-THOR's Unity build: no GPU, no display, the unmodified ai2thor Controller in front of it."""

import shlex
import sys


def executable() -> str:
    """What to give the Controller as `local_executable_path`."""
    return f"{shlex.quote(sys.executable)} -m ovman.engine"
