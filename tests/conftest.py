"""How tests are shared out among processes (`make test` runs two): by file, because fixtures last as long as a module.

All that runs Snakemake or waits for the one lock of the GPU stays in one process: it shares one finished world, and no lock is
waited for by two. That is the longest share, so it comes first.

Examples are drawn in the same way every time, so that a change fails for what it does; `pytest --hypothesis-profile default`
draws others. Mutation testing takes `mutants`, which does not look for the smallest example of what fails.
"""

from __future__ import annotations

import gc
from collections.abc import Generator
from pathlib import PurePosixPath

import pytest
from hypothesis import Phase, settings

settings.register_profile("same", derandomize=True)
settings.register_profile("mutants", derandomize=True, deadline=None, phases=(Phase.explicit, Phase.generate))
settings.load_profile("same")

WORKFLOW = "workflow"
TOGETHER = frozenset({"test_job.py"})


def share(nodeid: str) -> str:
    """What one process runs of the tests, by a test's name: its file, or all that runs Snakemake."""
    file = PurePosixPath(nodeid.partition("::")[0])
    return WORKFLOW if WORKFLOW in file.parts or file.name in TOGETHER else str(file)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """No garbage is collected while tests are: what is imported stays, and was gone through 25 times in each process."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest share to the beginning."""
    items.sort(key=lambda item: share(item.nodeid) != WORKFLOW)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """xdist's shares by file, with those that run Snakemake as one.

    Not by its marks for groups: xdist 3.8 writes them into what pytest 9.2 no longer reads, and shares out test by test.
    """
    from xdist.scheduler import LoadScopeScheduling

    class Shares(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return share(nodeid)

    return Shares(config, log)
