"""A machine on which the Unity build seems to be: a Vulkan that names a GPU, and a build in whose place the engine stands."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from ovman.sim import unity
from ovman_engine import executable

GPU = "deviceName = Some card\\n  deviceType = PHYSICAL_DEVICE_TYPE_DISCRETE_GPU"


def program(folder: Path, name: str, script: str) -> None:
    """A program `name` in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(f"#!/bin/sh\n{script}\n")
    (folder / name).chmod(0o755)


def library(folder: Path, present: bool) -> None:
    """Programs for the front of PATH by which Python finds Vulkan's library, or does not."""
    place = folder / "libvulkan.so.1"
    folder.mkdir(parents=True, exist_ok=True)
    if present and not place.exists():
        place.symlink_to(Path(sys.executable).resolve())  # what is looked for must be an ELF file
    for name, script in {"gcc": f"echo {place}", "objdump": "echo '  SONAME  libvulkan.so.1'"}.items():
        program(folder, name, script if present else "exit 1")
    program(folder, "ld", "exit 1")


def build(home: Path, command: str | None = None) -> Path:
    """The build below a home, with what it does instead: by default, the engine stands in its place."""
    folder = home / ".ai2thor" / "releases" / unity.build().name
    program(folder, folder.name, command or f'exec {executable()} "$@"')
    (folder / "metadata.json").write_text(json.dumps({"server_types": ["FIFO", "WSGI"]}))
    return folder


def machine(monkeypatch, folder: Path) -> Path:
    """All of it, as this process and those that it starts see it. Its home."""
    home, programs = folder / "home", folder / "programs"
    home.mkdir(parents=True)
    library(programs, present=True)
    program(programs, "vulkaninfo", f'printf "  {GPU}\\n"')
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("PATH", f"{programs}:{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
    monkeypatch.delenv("CUDA_VISIBLE_DEVICES", raising=False)
    build(home)
    return home
