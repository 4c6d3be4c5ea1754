rule candidates:
    input:
        scene="results/scenes/{scene}.json",
    output:
        candidates="results/candidates/{scene}.jsonl",
    log:
        "logs/candidates/{scene}.log",
    benchmark:
        "benchmarks/candidates/{scene}.tsv"
    params:
        constants=stage("candidates"),
    script:
        "../scripts/candidates.py"
