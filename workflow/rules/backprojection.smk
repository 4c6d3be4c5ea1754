rule backprojection:
    input:
        scenes=expand("results/scenes/{scene}.json", scene=SCENES),
        visits=expand("results/visits/{scene}.json", scene=SCENES),
        detections=expand("results/detections/{scene}.npz", scene=SCENES),
    output:
        backprojection="results/metrics/backprojection.csv",
    log:
        "logs/backprojection.log",
    benchmark:
        "benchmarks/backprojection.tsv"
    params:
        constants=stage("backprojection"),
    script:
        "../scripts/backprojection.py"
