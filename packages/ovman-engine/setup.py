"""Compiles the kernels that draw (kernels/*.cpp) with the machine's C++ compiler, or with Zig's where it has none."""

import os
import platform
import shutil
import sys
from pathlib import Path

from pybind11.setup_helpers import ParallelCompile, Pybind11Extension
from setuptools import setup

NO_COMPILER = "CXX" not in os.environ and not shutil.which("c++")
if NO_COMPILER:
    os.environ["CC"], os.environ["CXX"] = (f"{sys.executable} -m ziglang {tool}" for tool in ("cc", "c++"))

# Equal inputs give equal bytes on every processor: nothing is contracted, reordered or tuned to this machine.
FLAGS = ["-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math", "-fvisibility=hidden"]
if platform.machine() in ("x86_64", "AMD64"):
    FLAGS.append("-msse4.1")  # rounds in one instruction; every such processor since 2008 has it

SOURCES = sorted(str(path) for path in Path("kernels").glob("*.cpp"))
HEADERS = sorted(str(path) for path in Path("kernels").glob("*.hpp"))

ParallelCompile(default=os.cpu_count() or 1).install()
setup(
    setup_requires=["ziglang"] if NO_COMPILER else [],
    ext_modules=[
        Pybind11Extension(
            "ovman_engine.kernels", SOURCES, depends=HEADERS, cxx_std=17, extra_compile_args=FLAGS, extra_link_args=["-s"]
        )
    ],
)
