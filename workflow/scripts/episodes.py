"""Stage `episodes`: the released split, and the audit of what was rejected."""

from typing import Any

from ovman.generation import episodes
from ovman.job import job

snakemake: Any
with job(snakemake) as work:
    episodes.run(
        work.inputs("trials"),
        work.inputs("admissible"),
        work.inputs("certified"),
        work.constants,
        work.output("episodes"),
        work.output("rejections"),
    )
