# The one rule that owns results/tables: another output below it would make the directory impossible as a target.
rule tables:
    input:
        static="results/metrics/static_rates.csv",
        embodied="results/metrics/embodied_rates.csv",
        rejections="results/metrics/rejections.csv",
    output:
        tables=directory("results/tables"),
    log:
        "logs/tables.log",
    benchmark:
        "benchmarks/tables.tsv"
    params:
        constants=stage("tables"),
    script:
        "../scripts/tables.py"
