"""Stage `nouns`: the embedding of every noun phrase of the vocabulary."""

from ovman.language.vocabulary import all_nouns
from ovman.perception import nouns
from ovman.workflow.job import job

with job(snakemake) as work:
    nouns.run(all_nouns(), work.constants, work.output("nouns"))
