# Beside its output it keeps the recorded tours, results/visits/{scene}/{visit}/, which a later run uses again.
rule trials:
    input:
        candidates="results/candidates/{scene}.jsonl",
        scene="results/scenes/{scene}.json",
    output:
        trials="results/trials/{scene}.jsonl",
    log:
        "logs/trials/{scene}.log",
    benchmark:
        "benchmarks/trials/{scene}.tsv"
    resources:
        gpu=GPU,
    retries: 2
    params:
        constants=canonical(CONFIG, "trials"),
    script:
        "../scripts/trials.py"
