"""Stage `released_dualmap`: the maps of DualMap as its authors released it; empty files where it cannot be run."""

import json
from pathlib import Path

from ovman.agents.dualmap import maps, walks
from ovman.language.vocabulary import all_nouns
from ovman.workflow.job import job
from ovman.workflow.provenance import digest
from ovman_released import dualmap, status

with job(snakemake) as work:
    outputs = work.output("maps"), work.output("nouns")
    if status.read(work.input("status")).run:
        inputs = work.input("episodes"), work.input("trials")
        dualmap.run(
            work.scene,
            walks.assigned(work.scene, *inputs, Path("results/visits", work.scene)),
            maps.pairs_of(work.scene, *inputs),
            json.loads(work.input("scene").read_text())["floor_y"],
            sorted(set(all_nouns())),
            work.constants,
            [digest(Path(module.__file__)) for module in dualmap.CODE],
            work.journal().with_suffix(""),
            *outputs,
        )
    else:
        for output in outputs:
            output.touch()
