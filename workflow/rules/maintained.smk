# The one map of both visits of each episode, for arms that do not tell visits apart.
rule maintained:
    input:
        episodes="results/episodes/main.jsonl",
        detections=expand("results/detections/{scene}.npz", scene=SCENES),
    output:
        maintained=expand("results/maintained/{scene}.npz", scene=SCENES),
    log:
        "logs/maintained.log",
    benchmark:
        "benchmarks/maintained.tsv"
    params:
        constants=stage("maintained"),
    script:
        "../scripts/maintained.py"
