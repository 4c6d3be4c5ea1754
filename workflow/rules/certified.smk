rule certified:
    input:
        admissible="results/admissible/{scene}.jsonl",
        trials="results/trials/{scene}.jsonl",
    output:
        certified="results/certified/{scene}.jsonl",
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
