"""How tests are shared out among processes (`make test` runs two): by file, because fixtures last as long as a module.

All that runs Snakemake or waits for the one lock of the GPU stays in one process: it shares one finished world, and no lock is
waited for by two. That is the longest share, so it comes first.
"""

from __future__ import annotations

from pathlib import Path

import pytest

WORKFLOW = Path(__file__).parent / "workflow"
TOGETHER = frozenset({"test_job.py"})


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Name each test's share, and sort the longest to the beginning."""
    for item in items:
        together = WORKFLOW in item.path.parents or item.path.name in TOGETHER
        item.add_marker(pytest.mark.xdist_group("workflow" if together else f"{item.path.parent.name}-{item.path.stem}"))
    items.sort(key=lambda item: (WORKFLOW not in item.path.parents, item.path.name not in TOGETHER))
