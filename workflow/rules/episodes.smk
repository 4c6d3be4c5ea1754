rule episodes:
    input:
        scenes=expand("results/scenes/{scene}.json", scene=SCENES),
        trials=expand("results/trials/{scene}.jsonl", scene=SCENES),
        admissible=expand("results/admissible/{scene}.jsonl", scene=SCENES),
        certified=expand("results/certified/{scene}.jsonl", scene=SCENES),
    output:
        episodes=[f"results/episodes/{split}.jsonl" for split in SPLITS],
        sightings=["results/episodes/sightings.jsonl", *(f"results/episodes/{split}_sightings.jsonl" for split in FURTHER)],
        rejections=["results/metrics/rejections.csv", *(f"results/metrics/{split}_rejections.csv" for split in FURTHER)],
    log:
        "logs/episodes.log",
    benchmark:
        "benchmarks/episodes.tsv"
    params:
        constants=stage("episodes"),
    script:
        "../scripts/episodes.py"
