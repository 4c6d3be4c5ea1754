# The tours once more, with the frames between their views. What a walk showed is kept in results/journal/walks/{scene}/.


rule walks:
    input:
        episodes="results/episodes/main.jsonl",
        visits="results/visits/{scene}.json",
        networks=weights("detector.weights", "encoder.weights", "encoder.model"),
    output:
        walks="results/walks/{scene}.npz",
    log:
        "logs/walks/{scene}.log",
    benchmark:
        "benchmarks/walks/{scene}.tsv"
    resources:
        gpu=max(GPU, NETWORK_GPU),
    params:
        constants=stage("walks"),
    script:
        "../scripts/walks.py"
