# The tables of the paper: splits `main` and `multi`, every arm, the statistics, the audit of rejections.
# Only this rule writes into results/tables: another output below it would make the directory impossible as a target.
rule tables:
    input:
        metrics=with_episodes(
            expand("results/metrics/{name}.csv", name=registry.paper_tables(settings))
        ),
        notes=expand("results/notes/{plugin}.json", plugin=dict.fromkeys(arm.made_by for arm in ARMS if arm.made_by)),
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


# The tables that the other splits add, and those across all splits.
rule all_tables:
    input:
        tables="results/tables",
        metrics=with_episodes(
            expand("results/metrics/{name}.csv", name=registry.all_tables(settings))
        ),
    output:
        tables=report(
            directory("results/all"),
            caption="../report/tables.rst",
            category="Tables of all splits",
            patterns=["{table}.csv"],
            labels={"table": "{table}"},
        ),
    log:
        "logs/all_tables.log",
    benchmark:
        "benchmarks/all_tables.tsv"
    params:
        constants=stage("split_tables"),
    script:
        "../scripts/split_tables.py"
