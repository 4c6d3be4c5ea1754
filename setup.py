"""Add config files, networks, released files and the leaderboard to a wheel, which pyproject.toml cannot."""

from __future__ import annotations

import runpy
import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).parent
SHIPPED = runpy.run_path(str(HERE / "ovman" / "shipped.py"))


class BuildWithFiles(build_py):
    """A build command that copies the shipped files into the package."""

    def run(self) -> None:
        """Build the package, then copy the files."""
        super().run()
        if self.editable_mode:  # an editable install reads them in the checkout
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
