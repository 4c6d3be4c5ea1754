"""Kernels of numerical libraries that give the same bits on every processor that has them. Imports nothing heavy."""

from __future__ import annotations

import os
from pathlib import Path

ONE_KERNEL = {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR"}
"""OpenBLAS adds in the order of the widest vectors that a processor has, and the last bits of a depth follow; with AVX-512 NumPy
has other tangents, powers and exponentials. These kernels run on every x86-64 processor with AVX2 and FMA, so that all of them
give the same bits."""
CPU_INFO = Path("/proc/cpuinfo")


def hold() -> None:
    """Have NumPy, if it is imported only after this, and NumPy in processes that this one starts, add in one order everywhere.

    OpenBLAS gets one thread, because sums depend on the number of threads, and `ONE_KERNEL` if the machine runs it.
    """
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    if runs_one_kernel():
        os.environ.update(ONE_KERNEL)


def runs_one_kernel(cpu_info: Path = CPU_INFO) -> bool:
    """Return whether this machine's processors run the kernels of `ONE_KERNEL`; False if unknown."""
    try:
        lines = cpu_info.read_text(encoding="utf-8").splitlines()
    except OSError:
        return False
    flags = [line.partition(":")[2].split() for line in lines if line.partition(":")[0].strip() == "flags"]
    return bool(flags) and all({"avx2", "fma"} <= {*of_processor} for of_processor in flags)
