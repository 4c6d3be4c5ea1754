"""What pyproject.toml cannot say: a wheel also holds config.yaml, the networks, the released files and the leaderboard."""

from __future__ import annotations

import runpy
import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).parent
SHIPPED = runpy.run_path(str(HERE / "ovman" / "shipped.py"))


class BuildWithFiles(build_py):
    """Copies the files beside the package into the one that is built."""

    def run(self) -> None:
        """Build, then copy."""
        super().run()
        if self.editable_mode:  # they are read where they lie
            return
        inside = Path(self.build_lib) / "ovman" / SHIPPED["INSIDE"].name
        shutil.rmtree(inside, ignore_errors=True)
        for name in (*SHIPPED["FILES"], "leaderboard"):
            source, place = HERE / name, inside / name
            place.parent.mkdir(parents=True, exist_ok=True)
            if source.is_dir():
                shutil.copytree(source, place)
            else:
                shutil.copy2(source, place)


setup(cmdclass={"build_py": BuildWithFiles})
