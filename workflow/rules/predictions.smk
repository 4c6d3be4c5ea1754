rule predictions:
    input:
        episodes="results/episodes/main.jsonl",
        sightings=handed("results/episodes/sightings.jsonl"),
        visits=needed(["tours"], *expand("results/visits/{scene}.json", scene=SCENES)),
        maps=needed(["maps"], *expand("results/maps/{scene}.npz", scene=SCENES)),
        dualmap=needed(["dualmap"], *expand("results/dualmap/{scene}.npz", scene=SCENES)),
        nouns=needed(["maps", "dualmap"], "results/nouns.npz"),
        networks=needed(["networks"], *weights("detector.weights", "encoder.weights", "encoder.model")),
    output:
        predictions="results/predictions/{arm}.jsonl",
    log:
        "logs/predictions/{arm}.log",
    benchmark:
        "benchmarks/predictions/{arm}.tsv"
    wildcard_constraints:
        arm=OF_NO_PLUGIN,
    resources:
        gpu=network_gpu,
    params:
        constants=stage_of_arm("predictions"),
    script:
        "../scripts/predictions.py"
