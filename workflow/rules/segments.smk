# Both tours of every episode weighed against each other, once for all arms that decide on it.
rule segments:
    input:
        episodes=episodes_of_scene,
        visits="results/visits/{scene}.json",
        detections="results/detections/{scene}.npz",
    output:
        segments="results/segments/{scene}.npz",
    log:
        "logs/segments/{scene}.log",
    benchmark:
        "benchmarks/segments/{scene}.tsv"
    params:
        constants=stage("segments"),
    script:
        "../scripts/segments.py"
