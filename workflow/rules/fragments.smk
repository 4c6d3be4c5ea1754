rule fragments:
    input:
        episodes="results/episodes/main.jsonl",
        predictions=f"results/predictions/{settings.comparisons.memory.arm}.jsonl",
        scenes=expand("results/scenes/{scene}.json", scene=SCENES),
        visits=expand("results/visits/{scene}.json", scene=SCENES),
        detections=expand("results/detections/{scene}.npz", scene=SCENES),
        maps=expand("results/maps/{scene}.npz", scene=SCENES),
    output:
        fragments="results/metrics/fragments.csv",
    log:
        "logs/fragments.log",
    benchmark:
        "benchmarks/fragments.tsv"
    params:
        constants=stage("fragments"),
    script:
        "../scripts/fragments.py"
