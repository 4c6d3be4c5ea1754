"""What the process of CoW's released runner finds of this project, in an environment where nothing of it is installed."""

from __future__ import annotations

import subprocess
import sys

from settings_of import settings_of

from ovman_engine import COMMAND
from ovman_released import cow
from ovman_released.settings import released_cow


def test_all_of_our_packages_are_found_where_none_is_installed(monkeypatch, tmp_path):
    """The engine's package, too, which says how the engine is started; its own requirements are those of OVMAN's Python."""
    settings = settings_of("cow", released_cow={"root": str(tmp_path), "python": sys.executable, "device": "cpu"})
    started = []
    with monkeypatch.context() as instead:
        instead.setattr(cow.subprocess, "Popen", lambda command, **options: started.append((command, options["env"])))
        cow.call([], 0, released_cow(settings), tmp_path)
    (((python, *_), env),) = started
    # -S leaves out the environment's own packages, as those of a clone have none of ours.
    program = "import ovman, ovman_released, ovman_engine; print(ovman_engine.executable())"
    done = subprocess.run([python, "-S", "-c", program], cwd=tmp_path, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == env[COMMAND]
