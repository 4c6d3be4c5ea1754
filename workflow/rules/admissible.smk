rule admissible:
    input:
        trials="results/trials/{scene}.jsonl",
    output:
        "results/admissible/{scene}.jsonl",
    log:
        "logs/admissible/{scene}.log",
    params:
        constants=stage("admissible"),
    script:
        "../scripts/admissible.py"
