# One file of metrics a table (ovman/report/tables.py).
SHOWN = [
    "static_rates",
    "embodied_rates",
    "rejections",
    "taxonomy",
    "significance",
    "navigation",
    "difficulty",
    "budget",
    "pairings",
    "own_task",
    "seeds",
    "scenes",
    "language",
    "perception",
    "backprojection",
    *(["dualmap"] if OF_DUALMAP else []),
]


# The one rule that owns results/tables: another output below it would make the directory impossible as a target.
rule tables:
    input:
        metrics=expand("results/metrics/{name}.csv", name=SHOWN),
        notes=expand("results/notes/{plugin}.json", plugin=dict.fromkeys(arm.made_by for arm in ARMS if arm.made_by)),
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
