"""An engine that replaces AI2-THOR's Unity build: CPU only, no display, behind the unmodified ai2thor Controller."""

import os
import shlex
import sys

__version__ = "0.5.0.dev0"
DISPLAY = ":0"
"""Display name for a client that asks for one. Nothing connects to it."""
COMMAND = "OVMAN_ENGINE"
"""Environment variable with the engine's command line, for clients whose own Python lacks the engine's packages."""
MASKS_ONLY = "renderMasksOnly"
"""Key that any action may carry: of all images, its event then carries instance masks only. Colours take four fifths of the time
of an image. AI2-THOR has no such key."""
STRICT = "OVMAN_ENGINE_STRICT"
"""Environment variable: set to 1, every action refuses arguments that it does not know. AI2-THOR's old actions accept any."""


def executable() -> str:
    """Return the engine's command line: the value for the Controller's argument `local_executable_path`.

    The client starts nothing while the environment has no DISPLAY, so this function sets one if it is missing.
    """
    os.environ.setdefault("DISPLAY", DISPLAY)
    return os.environ.get(COMMAND) or f"{shlex.quote(sys.executable)} -m ovman_engine"
