"""Stage `ablation`: what each setting of a split costs each static arm, as rates and as a table."""

from ovman.analysis.probes import write_ablation
from ovman.report.tables import write_ablation_table
from ovman.workflow.job import job

with job(snakemake) as work:
    answered = work.inputs("predictions")
    variants = {
        episodes.stem: (episodes, [path for path in answered if path.parent.name == episodes.stem])
        for episodes in work.inputs("episodes")
    }
    write_ablation(variants, work.constants, work.output("rates"))
    write_ablation_table(work.split, work.output("rates"), work.constants, work.output("table"))
