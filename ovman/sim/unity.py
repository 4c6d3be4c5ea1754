"""AI2-THOR's Unity build: its requirements, its place and its download.

`python -m ovman.sim.unity` downloads it in a process of its own, which can be ended: the client waits for the server without a
limit.
"""

from __future__ import annotations

import ctypes.util
import os
import shutil
import subprocess
import sys
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ai2thor.build import Build

DOWNLOAD_LIMIT_S = 1800.0
"""Time limit of the download, somewhat less than 1 GB."""
REACH_LIMIT_S = 20.0
"""Time limit of the server's answer."""
VULKANINFO_LIMIT_S = 30.0
DRIVER = "the GPU's own driver with its Vulkan part (NVIDIA's is libnvidia-gl-NNN on Ubuntu, nvidia-vulkan-icd on Debian)"


class Missing(ValueError):
    """The machine lacks a requirement of the Unity build; one line with the requirement and the remedy."""

    says_all = True

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(f"benchmark.backend is thor, but {what}; {remedy}")
        self.what, self.remedy = what, remedy


def find_gpus() -> list[str] | None:
    """Return the names of the GPUs that Vulkan has; None if `vulkaninfo` is not installed. Raises Missing if there is none."""
    if ctypes.util.find_library("vulkan") is None:
        raise Missing("Vulkan's library is not installed", f"sudo apt install libvulkan1 vulkan-tools, and {DRIVER}")
    if shutil.which("vulkaninfo") is None:
        if any(device.strip().isdigit() for device in os.environ.get("CUDA_VISIBLE_DEVICES", "").split(",")):
            raise Missing(
                "CUDA_VISIBLE_DEVICES chooses a GPU and vulkaninfo, which the client finds it with, is not installed",
                "sudo apt install vulkan-tools, or unset CUDA_VISIBLE_DEVICES",
            )
        return None
    remedy = f"install {DRIVER}"
    try:
        said = subprocess.run(["vulkaninfo", "--summary"], capture_output=True, text=True, timeout=VULKANINFO_LIMIT_S)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Missing(f"vulkaninfo does not answer ({type(error).__name__})", remedy) from None
    fields = [[part.strip() for part in line.split("=", 1)] for line in said.stdout.splitlines() if "=" in line]
    names, kinds = ([value for key, value in fields if key == wanted] for wanted in ("deviceName", "deviceType"))
    if said.returncode != 0 or not names:
        lines = said.stderr.split("\n") if said.returncode else []
        raise Missing(f"Vulkan finds no device ({next(filter(None, lines), 'vulkaninfo names none').strip()})", remedy)
    gpus = [name for name, kind in zip_longest(names, kinds, fillvalue="") if name and not kind.endswith("_CPU")]
    if not gpus:
        raise Missing(f"Vulkan draws without a GPU here ({', '.join(names)})", remedy)
    return gpus


def build() -> Build:
    """Return the build that the client starts."""
    from ai2thor.build import COMMIT_ID, Build
    from ai2thor.platform import CloudRendering

    return Build(CloudRendering, COMMIT_ID, False, str(Path.home() / ".ai2thor" / "releases"))


def is_present() -> bool:
    """Return whether the build is complete where the client looks for it."""
    wanted = build()
    return Path(wanted.executable_path).is_file() and Path(wanted.metadata_path).is_file()


def fetch(limit_s: float = DOWNLOAD_LIMIT_S) -> None:
    """Download the build if it is missing. Raises Missing, at the latest after `limit_s` seconds."""
    if is_present():
        return
    remedy = f"see to it that {build().url} can be reached, or copy ~/.ai2thor from a machine that has the build"
    print(f"downloading {build().url} to {build().releases_dir}", flush=True)
    try:
        said = subprocess.run([sys.executable, "-m", "ovman.sim.unity"], capture_output=True, text=True, timeout=limit_s)
    except subprocess.TimeoutExpired:
        raise Missing(f"its build was not downloaded within {limit_s:g} s", remedy) from None
    if said.returncode != 0 or not is_present():
        why = (said.stderr.strip() or "it ended without a word").splitlines()[-1][:200]
        raise Missing(f"its build cannot be downloaded ({why})", remedy)


def download() -> None:
    """Download the build."""
    from urllib.request import Request, urlopen

    wanted = build()
    urlopen(Request(wanted.url, method="HEAD"), timeout=REACH_LIMIT_S).close()
    wanted.download()
    wanted.download_metadata()


if __name__ == "__main__":
    download()
