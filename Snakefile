# OVMAN, from floor plans to tables. Stages in the order of the paper; one file a stage in workflow/rules/.
#
#   results/scenes/{scene}.json -> candidates -> trials (+ visits) -> admissible -> certified
#       -> results/episodes/main.jsonl, results/metrics/rejections.csv
#       -> results/predictions/{arm}.jsonl, results/rollouts -> results/scores/{arm}/seed{seed}/{scene}.jsonl
#       -> results/metrics/*.csv -> results/tables/ (the paper's splits), results/all/ (every split)

import sys

from snakemake.utils import min_version

# This checkout's code, whichever ovman the environment has installed.
sys.path.insert(0, str(workflow.basedir))

from ovman.settings.settings_files import check_file, with_parts

min_version("9.19")
CONFIG_FILES = with_parts(Path(workflow.basedir, "config.yaml"))
for file in CONFIG_FILES:
    check_file(file)


    configfile: file


report: "workflow/report/workflow.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/simulator.smk"
include: "workflow/rules/scenes.smk"
include: "workflow/rules/candidates.smk"
include: "workflow/rules/trials.smk"
include: "workflow/rules/admissible.smk"
include: "workflow/rules/certified.smk"
include: "workflow/rules/episodes.smk"
include: "workflow/rules/detections.smk"
include: "workflow/rules/cues.smk"
include: "workflow/rules/labels.smk"
include: "workflow/rules/maps.smk"
include: "workflow/rules/maintained.smk"
include: "workflow/rules/segments.smk"
include: "workflow/rules/nouns.smk"
include: "workflow/rules/walks.smk"
include: "workflow/rules/dualmap.smk"
include: "workflow/rules/predictions.smk"
include: "workflow/rules/splits.smk"
include: "workflow/rules/rollouts.smk"
include: "workflow/rules/scores.smk"
include: "workflow/rules/metrics.smk"
include: "workflow/rules/controls.smk"
include: "workflow/rules/language.smk"
include: "workflow/rules/perception.smk"
include: "workflow/rules/backprojection.smk"
include: "workflow/rules/readmitted.smk"
include: "workflow/rules/probes.smk"
include: "workflow/rules/fragments.smk"
include: "workflow/rules/appearance.smk"
include: "workflow/rules/ablation.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/static_tables.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/paper_comparison.smk"
include: "workflow/rules/models.smk"


for plugin in PLUGINS:

    include: plugin.rules


onstart:
    lift_rate_limit(workflow)


onsuccess:
    if not overlays(workflow):
        from ovman.report.compare import print_comparison

        print_comparison(settings)


onerror:
    print_deaths()


localrules:
    all,


rule all:
    default_target: True
    input:
        "results/tables",
