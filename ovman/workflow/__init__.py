"""The workflow around the stages: settings and their owners, jobs, journals, checksums, digests of code, and Snakemake."""
