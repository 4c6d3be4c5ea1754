rule perception:
    input:
        scenes=expand("results/scenes/{scene}.json", scene=SCENES),
        visits=expand("results/visits/{scene}.json", scene=SCENES),
        detections=expand("results/detections/{scene}.npz", scene=SCENES),
        episodes=[f"results/episodes/{split}.jsonl" for split in PAPER_SPLITS],
        nouns="results/nouns.npz",
    output:
        perception="results/metrics/perception.csv",
    log:
        "logs/perception.log",
    benchmark:
        "benchmarks/perception.tsv"
    params:
        constants=stage("perception"),
    script:
        "../scripts/perception.py"
