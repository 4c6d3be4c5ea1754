# The tables of the static gate without a drive, for who changes a constant of the agent: snakemake --cores 2 results/static
rule static:
    input:
        episodes="results/episodes/main.jsonl",
        predictions=expand("results/predictions/{arm}.jsonl", arm=STATIC),
    output:
        static=directory("results/static"),
    log:
        "logs/static.log",
    params:
        constants=stage("static"),
    script:
        "../scripts/static.py"
