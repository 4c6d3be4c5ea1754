"""Stage `encoder`: trains the image and text towers, from random weights or further from those that it is given."""

from ovman.workflow.job import job
from training import encoder

with job(snakemake) as work:
    held_out = {name: work.inputs(name) for name in ("true", "detected") if work.inputs(name)}
    start = next(iter(work.inputs("start")), None)
    encoder.run(work.inputs("taught"), held_out, work.constants, start, work.output("weights"), work.output("curve"))
