"""Stage `language`: held-out sentences, what is understood of them, and what the two-visit agent answers to that."""

from ovman.analysis import language
from ovman.workflow.job import job

with job(snakemake) as work, work.gathered() as directory:
    language.write_language(
        work.input("episodes"),
        work.input("supplied"),
        work.inputs("maps"),
        work.input("nouns"),
        work.input("held_out"),
        work.constants,
        directory,
        directory / "language.csv",
    )
