rule predictions:
    input:
        episodes="results/episodes/main.jsonl",
        trials=expand("results/trials/{scene}.jsonl", scene=SCENES),
        maps=own(*expand("results/maps/{scene}.npz", scene=SCENES)),
        nouns=own("results/nouns.npz"),
    output:
        predictions="results/predictions/{arm}.jsonl",
    log:
        "logs/predictions/{arm}.log",
    benchmark:
        "benchmarks/predictions/{arm}.tsv"
    params:
        constants=stage("predictions"),
    script:
        "../scripts/predictions.py"
