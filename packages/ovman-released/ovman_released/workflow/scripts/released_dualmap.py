"""Stage `released_dualmap`: the maps of DualMap as its authors released it; empty files where it cannot run."""

import json
from pathlib import Path

from ovman.agents.dualmap import maps, walks
from ovman.language.vocabulary import all_nouns
from ovman.records.episode import Episode
from ovman.records.note import Note
from ovman.workflow.job import job
from ovman.workflow.provenance import module_digest

with job(snakemake) as work:
    # The package may lie beside an overlay, where only a job looks for modules.
    from ovman_released import dualmap

    outputs = work.output("maps"), work.output("nouns")
    if Note.read(work.input("note")).ran:
        episodes = [episode for episode in Episode.load(work.input("episodes")) if episode.scene == work.scene]
        dualmap.run(
            work.scene,
            walks.assigned(episodes, Path("results/visits", work.scene)),
            maps.pairs_of(episodes),
            json.loads(work.input("scene").read_text())["floor_y"],
            sorted(set(all_nouns())),
            work.constants,
            [module_digest(module.__name__) for module in dualmap.CODE],
            work.journal().with_suffix(""),
            *outputs,
        )
    else:
        for output in outputs:
            output.touch()
