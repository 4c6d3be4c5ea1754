"""What a Snakemake works out of files that no test changes, for the process that Snakemakes of the tests are forked from: which
plug-ins of Snakemake there are, and the digests of what stages and agents of this checkout run. It is a third of a dry run.

A Snakemake that is no fork, as in tests/workflow/test_kill.py, finds them as a user's does.
"""

from __future__ import annotations

from snakemake.cli import get_argument_parser

from ovman.settings.config import load
from ovman.workflow.provenance import code_digest, module_digest, remember
from ovman.workflow.stages import STAGES
from tests.workflow.forked import ROOT, SOURCES

get_argument_parser()  # it lists what the plug-ins can be told
remember(SOURCES)
for stage in STAGES:
    code_digest(stage)
for arm in load(ROOT / "config.yaml").arms.values():
    module_digest(arm.agent.partition(":")[0])
