# Splits beside the benchmark's own: what the arms that they name answer, and how often that is right.


rule split_scores:
    input:
        episodes="results/episodes/{split}.jsonl",
        rollouts=rollouts_of,
    output:
        scores="results/scores/{split}/{arm}.jsonl",
    log:
        "logs/scores/{split}/{arm}.log",
    benchmark:
        "benchmarks/scores/{split}/{arm}.tsv"
    params:
        constants=stage_of_arm("scores"),
    script:
        "../scripts/scores.py"


rule split_metrics:
    input:
        episodes="results/episodes/{split}.jsonl",
        predictions=predictions_of_split,
        scores=scores_of_split,
    output:
        expand("results/metrics/{{split}}/{name}.csv", name=registry.SPLIT_METRICS),
    log:
        "logs/split_metrics/{split}.log",
    benchmark:
        "benchmarks/split_metrics/{split}.tsv"
    params:
        constants=stage("metrics"),
    script:
        "../scripts/metrics.py"


# The tables of one split, whether or not the main job has it: snakemake --cores 2 results/splits/NAME
rule split_tables:
    input:
        metrics=with_episodes(metrics_of_split),
    output:
        tables=directory("results/splits/{split}"),
    log:
        "logs/split_tables/{split}.log",
    benchmark:
        "benchmarks/split_tables/{split}.tsv"
    params:
        constants=stage("split_tables"),
    script:
        "../scripts/split_tables.py"
