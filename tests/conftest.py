"""How tests are shared out among processes (`make test` runs two): by file, because fixtures last as long as a module.

All that runs Snakemake or waits for the one lock of the GPU stays in one process: it shares one finished world, and no lock is
waited for by two. That is the longest share, so it comes first.

Examples are drawn in the same way every time, so that a change fails for what it does; `pytest --hypothesis-profile default`
draws others.
"""

from __future__ import annotations

from pathlib import Path, PurePosixPath

import pytest
from hypothesis import settings

settings.register_profile("same", derandomize=True)
settings.load_profile("same")

WORKFLOW = Path(__file__).parent / "workflow"
TOGETHER = frozenset({"test_job.py"})


def in_one_process(path: PurePosixPath) -> bool:
    """Whether a file of tests belongs to the share that runs Snakemake."""
    return WORKFLOW.name in path.parts or path.name in TOGETHER


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest share to the beginning."""
    items.sort(key=lambda item: (WORKFLOW not in item.path.parents, not in_one_process(item.path)))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """xdist's shares by file, with those that run Snakemake as one.

    Not by its marks for groups: xdist 3.8 writes them into what pytest 9.2 no longer reads, and shares out test by test.
    """
    from xdist.scheduler import LoadFileScheduling

    class Shares(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = super()._split_scope(nodeid)
            return WORKFLOW.name if in_one_process(PurePosixPath(file)) else file

    return Shares(config, log)
