rule candidates:
    input:
        scene="results/scenes/{scene}.json",
    output:
        "results/candidates/{scene}.jsonl",
    log:
        "logs/candidates/{scene}.log",
    params:
        constants=stage("candidates"),
    script:
        "../scripts/candidates.py"
