# The tables of the static gate before anything drives, to see what a constant of an agent does: snakemake --cores 2 results/static_tables
rule static_tables:
    input:
        episodes="results/episodes/main.jsonl",
        predictions=with_episodes(expand("results/predictions/{arm}.jsonl", arm=STATIC)),
    output:
        tables=directory("results/static_tables"),
    log:
        "logs/static_tables.log",
    params:
        constants=stage("static_tables"),
    script:
        "../scripts/static_tables.py"
