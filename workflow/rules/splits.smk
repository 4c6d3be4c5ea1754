# Splits beside the benchmark's own: what the arms that they name answer, and how often that is right.


rule split_metrics:
    input:
        episodes="results/episodes/{split}.jsonl",
        predictions=predictions_of_split,
    output:
        outcomes="results/metrics/{split}_outcomes.csv",
        rates="results/metrics/{split}_rates.csv",
    log:
        "logs/split_metrics/{split}.log",
    benchmark:
        "benchmarks/split_metrics/{split}.tsv"
    params:
        constants=stage("split_metrics"),
    script:
        "../scripts/split_metrics.py"
