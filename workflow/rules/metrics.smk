rule metrics:
    input:
        episodes="results/episodes/main.jsonl",
        predictions=expand("results/predictions/{arm}.jsonl", arm=STATIC),
        # A function: of many scenes every Snakemake that reads the rules would make a list that is longer than all others together.
        scores=lambda wildcards: expand("results/scores/{arm}/seed{seed}/{scene}.jsonl", arm=EMBODIED, seed=SEEDS, scene=SCENES),
    output:
        expand("results/metrics/main/{name}.csv", name=registry.SPLIT_METRICS),
    log:
        "logs/metrics.log",
    benchmark:
        "benchmarks/metrics.tsv"
    params:
        constants=stage("metrics"),
    script:
        "../scripts/metrics.py"
