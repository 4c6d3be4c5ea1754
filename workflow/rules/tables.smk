# The one rule that owns the directory: no other may write below it, so that the directory itself can be asked for.


rule tables:
    input:
        static="results/metrics/static_rates.csv",
        embodied="results/metrics/embodied_rates.csv",
        rejections="results/metrics/rejections.csv",
    output:
        directory("results/tables"),
    log:
        "logs/tables.log",
    params:
        constants=stage("tables"),
    script:
        "../scripts/tables.py"
