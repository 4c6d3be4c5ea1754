# The page of results, which links to the figures. No part of the main job: snakemake --cores 2 results/results.md
PAPER_COMPARISON = os.path.join(workflow.basedir, "ovman", "report", "paper_comparison")


rule paper_comparison:
    input:
        metrics=with_episodes(expand("results/metrics/{name}.csv", name=compared(ARMS))),
        paper=os.path.join(PAPER_COMPARISON, "paper.yaml"),
        statements=os.path.join(PAPER_COMPARISON, "statements.yaml"),
        own=os.path.join(PAPER_COMPARISON, "controls.yaml"),
        explanations=os.path.join(PAPER_COMPARISON, "explanations.yaml"),
        template=os.path.join(PAPER_COMPARISON, "page.md.j2"),
        position=os.path.join(workflow.basedir, "ovman", "report", "tables", "position.yaml"),
    output:
        page=report("results/results.md", caption="../report/paper_comparison.rst", category="Comparison with the paper"),
    log:
        "logs/paper_comparison.log",
    params:
        constants=stage("paper_comparison"),
    script:
        "../scripts/paper_comparison.py"
