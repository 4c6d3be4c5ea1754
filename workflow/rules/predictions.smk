rule predictions:
    input:
        episodes="results/episodes/main.jsonl",
        trials=expand("results/trials/{scene}.jsonl", scene=SCENES),
    output:
        "results/predictions/{arm}.jsonl",
    log:
        "logs/predictions/{arm}.log",
    params:
        constants=stage("predictions"),
    script:
        "../scripts/predictions.py"
