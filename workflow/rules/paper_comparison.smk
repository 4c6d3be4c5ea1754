# The page of results, which links to the figures. No part of the main job: snakemake --cores 2 results/results.md
rule paper_comparison:
    input:
        metrics=with_episodes(expand("results/metrics/{name}.csv", name=registry.compared(settings))),
        template=os.path.join(workflow.basedir, "ovman", "report", "results_page.md.j2"),
    output:
        page=report("results/results.md", caption="../report/paper_comparison.rst", category="Comparison with the paper"),
    log:
        "logs/paper_comparison.log",
    params:
        constants=stage("paper_comparison"),
    script:
        "../scripts/paper_comparison.py"
