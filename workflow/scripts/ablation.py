"""Stage `ablation`: what each setting of a split costs each static arm, as rates and as a table."""

from ovman.analysis import ablation, frames
from ovman.report.tables.ablation import ablation_table
from ovman.report.tables.stages import write
from ovman.workflow.job import job

with job(snakemake) as work:
    answered = work.inputs("predictions")
    variants = {
        episodes.stem: (episodes, [path for path in answered if path.parent.name == episodes.stem])
        for episodes in work.inputs("episodes")
    }
    ablation.run(variants, work.constants, work.output("rates"))
    rates = frames.read(work.output("rates"), ablation.AblationRate)
    write({"ablation": ablation_table(work.split, rates, work.constants)}, work.output("table"))
