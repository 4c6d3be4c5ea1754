# The one rule that owns results/tables: another output below it would make the directory impossible as a target.
rule tables:
    input:
        metrics=expand("results/metrics/{name}.csv", name=in_tables(ARMS, settings.splits)),
        notes=expand("results/notes/{plugin}.json", plugin=dict.fromkeys(arm.made_by for arm in ARMS if arm.made_by)),
        position=os.path.join(workflow.basedir, "ovman", "report", "tables", "position.yaml"),
    output:
        tables=report(
            directory("results/tables"),
            caption="../report/tables.rst",
            category="Tables",
            patterns=["{table}.csv"],
            labels={"table": "{table}"},
        ),
    log:
        "logs/tables.log",
    benchmark:
        "benchmarks/tables.tsv"
    params:
        constants=stage("tables"),
    script:
        "../scripts/tables.py"
