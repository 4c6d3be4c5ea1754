rule episodes:
    input:
        scenes=expand("results/scenes/{scene}.json", scene=SCENES),
        trials=expand("results/trials/{scene}.jsonl", scene=SCENES),
        admissible=expand("results/admissible/{scene}.jsonl", scene=SCENES),
        certified=expand("results/certified/{scene}.jsonl", scene=SCENES),
    output:
        episodes="results/episodes/main.jsonl",
        sightings="results/episodes/sightings.jsonl",
        rejections="results/metrics/rejections.csv",
    log:
        "logs/episodes.log",
    benchmark:
        "benchmarks/episodes.tsv"
    params:
        constants=stage("episodes"),
    script:
        "../scripts/episodes.py"
