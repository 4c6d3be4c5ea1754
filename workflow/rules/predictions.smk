rule predictions:
    input:
        episodes=episodes_answered,
        sightings=handed(sightings_answered),
        visits=needed(["tours"], *expand("results/visits/{scene}.json", scene=SCENES)),
        maps=needed(["maps"], *expand("results/maps/{scene}.npz", scene=SCENES)),
        maintained=needed(["maintained"], *expand("results/maintained/{scene}.npz", scene=SCENES)),
        dualmap=needed(["dualmap"], *expand("results/dualmap/{scene}.npz", scene=SCENES)),
        labels=labels_of_map,
        scenes=scenes_named,
        nouns=needed(["maps", "maintained", "dualmap"], "results/nouns.npz"),
        networks=needed(["networks"], *weights("detector.weights", "encoder.weights", "encoder.model")),
    output:
        predictions="results/predictions/{of}{arm}.jsonl",
    log:
        "logs/predictions/{of}{arm}.log",
    benchmark:
        "benchmarks/predictions/{of}{arm}.tsv"
    wildcard_constraints:
        arm=OF_NO_PLUGIN,
    resources:
        gpu=network_gpu,
    params:
        constants=stage_of_arm("predictions"),
    script:
        "../scripts/predictions.py"
