rule nouns:
    input:
        networks=weights("encoder.weights", "encoder.model"),
    output:
        nouns="results/nouns.npz",
    log:
        "logs/nouns.log",
    benchmark:
        "benchmarks/nouns.tsv"
    resources:
        gpu=NETWORK_GPU,
    params:
        constants=stage("nouns"),
    script:
        "../scripts/nouns.py"
