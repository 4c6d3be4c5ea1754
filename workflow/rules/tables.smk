# The one rule that owns results/tables: another output below it would make the directory impossible as a target.
rule tables:
    input:
        metrics=expand("results/metrics/{name}.csv", name=registry.in_tables(ARMS)),
        released=expand("results/released/{system}.json", system=RELEASED),
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
