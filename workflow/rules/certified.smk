rule certified:
    input:
        trials="results/trials/{scene}.jsonl",
        admissible="results/admissible/{scene}.jsonl",
    output:
        "results/certified/{scene}.jsonl",
    log:
        "logs/certified/{scene}.log",
    benchmark:
        "benchmarks/certified/{scene}.tsv"
    resources:
        gpu=GPU,
    params:
        constants=stage("certified"),
    script:
        "../scripts/certified.py"
