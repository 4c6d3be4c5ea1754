# Metrics across splits: the overview, controls next to agents, one arm against another. In results/metrics of all splits of
# results/all, in results/metrics/paper of those of results/tables.


rule controls:
    input:
        metrics=metrics_across(JOB_SPLITS),
    output:
        controls="results/metrics/controls.csv",
        coverage="results/metrics/coverage.csv",
        overview="results/metrics/overview.csv",
        split_significance="results/metrics/split_significance.csv",
    log:
        "logs/controls.log",
    params:
        constants=stage("controls"),
    script:
        "../scripts/controls.py"


use rule controls as paper_controls with:
    input:
        metrics=metrics_across(PAPER_SPLITS),
    output:
        controls="results/metrics/paper/controls.csv",
        coverage="results/metrics/paper/coverage.csv",
        overview="results/metrics/paper/overview.csv",
        split_significance="results/metrics/paper/split_significance.csv",
    log:
        "logs/paper_controls.log",
