# The weights of the cues are fitted on each split and tested on all of them. The predictions of the arm of section `appearance` say
# which objects of its maps the noun means.
APPEARANCE = ["results/predictions"] + [f"results/predictions/{split}" for split in PAPER_SPLITS[1:]]


rule appearance:
    input:
        episodes=[f"results/episodes/{split}.jsonl" for split in PAPER_SPLITS],
        predictions=[f"{folder}/{settings.appearance.agent}.jsonl" for folder in APPEARANCE],
        maps=expand("results/maps/{scene}.npz", scene=SCENES),
        cues=expand("results/cues/{scene}.npz", scene=SCENES),
    output:
        appearance="results/metrics/appearance.csv",
    log:
        "logs/appearance.log",
    benchmark:
        "benchmarks/appearance.tsv"
    params:
        constants=stage("appearance"),
    script:
        "../scripts/appearance.py"
