"""Stage `graphs`: both trained networks as graphs, and the embeddings of phrases."""

from training import graphs
from ovman.workflow.job import job

with job(snakemake) as work:
    files = {name: work.output(name) for name in ("detector", "encoder", "phrases")}
    graphs.run(work.input("detector"), work.input("encoder"), work.constants, files)
