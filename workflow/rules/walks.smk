# The tours once more, with the frames between their views, and what the observations truly show, for diagnostic arms alone. What a walk showed is kept in results/journal/walks/{scene}/.


rule walks:
    input:
        scene="results/scenes/{scene}.json",
        episodes="results/episodes/main.jsonl",
        visits="results/visits/{scene}.json",
        networks=weights("detector.weights", "encoder.weights", "encoder.model"),
    output:
        walks="results/walks/{scene}.npz",
        labels="results/walk_labels/{scene}.npz",
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
