rule admissible:
    input:
        trials="results/trials/{scene}.jsonl",
    output:
        admissible="results/admissible/{scene}.jsonl",
    log:
        "logs/admissible/{scene}.log",
    benchmark:
        "benchmarks/admissible/{scene}.tsv"
    params:
        constants=stage("admissible"),
    script:
        "../scripts/admissible.py"
