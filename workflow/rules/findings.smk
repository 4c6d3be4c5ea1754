# The page of results and its charts. No part of the main job: snakemake --cores 2 results/results.md
READ = [
    "static_rates",
    "embodied_rates",
    "significance",
    "navigation",
    "taxonomy",
    "difficulty",
    "budget",
    "pairings",
    "own_task",
    "seeds",
    "language",
    "perception",
    "backprojection",
    *(["dualmap"] if OF_DUALMAP else []),
]
REPORT = os.path.join(workflow.basedir, "ovman", "report")


rule findings:
    input:
        metrics=expand("results/metrics/{name}.csv", name=READ),
        paper=os.path.join(REPORT, "paper.yaml"),
        explanations=os.path.join(REPORT, "paper_comparison", "explanations.yaml"),
        template=os.path.join(REPORT, "paper_comparison", "page.md.j2"),
    output:
        page="results/results.md",
        budget="results/figures/budget.png",
        memory="results/figures/memory.png",
    log:
        "logs/findings.log",
    params:
        constants=stage("findings"),
    script:
        "../scripts/findings.py"
