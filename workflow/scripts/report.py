"""The rules of report.smk: metrics, tables, figures and the page about the paper.

Each function is called like its rule and imports what it calls: a job starts sooner without the modules of other rules.
"""

from pathlib import Path

from stage import Job, run

METRICS, VISITS = Path("results", "metrics"), Path("results", "visits")


def metrics(job: Job) -> None:
    from ovman.analysis import metrics as of_splits

    scores = sorted(job.file("scores").glob("*.jsonl"))
    of_splits.write_metrics(job.file("episodes"), job.files("predictions"), scores, job.settings, job.folder)


def across_splits(job: Job) -> None:
    from ovman.analysis import splits as across

    folders = {split: METRICS / split for split in job.params.splits}
    across.write_across_splits(folders, job.settings, job.folder)


def language(job: Job) -> None:
    from ovman.analysis import language as sentences

    files = job.file("episodes"), job.file("supplied"), job.files("maps"), job.file("nouns"), job.file("held_out")
    sentences.write_language(*files, job.settings, job.folder, Path(job.output.language))


def perception(job: Job) -> None:
    from ovman.analysis import backprojection
    from ovman.analysis import perception as sight

    scenes, detections = job.files("scenes"), job.files("detections")
    files = job.files("episodes"), job.file("nouns")
    sight.write_perception(scenes, detections, *files, VISITS, job.settings, Path(job.output.perception))
    backprojection.write_backprojection(scenes, detections, VISITS, job.settings, Path(job.output.backprojection))


def appearance(job: Job) -> None:
    from ovman.analysis import appearance as cue_weights

    files = [job.files(name) for name in ("episodes", "predictions", "scenes", "detections", "maps")]
    cue_weights.write_appearance(*files, VISITS, job.settings, Path(job.output.appearance), job.workers)


def fragments(job: Job) -> None:
    from ovman.analysis import maps as map_quality

    files = job.file("episodes"), job.file("predictions"), *(job.files(name) for name in ("scenes", "detections", "maps"))
    map_quality.write_fragments(*files, VISITS, job.settings, Path(job.output.fragments))


def dualmap_objects(job: Job) -> None:
    from ovman.analysis import maps as map_quality

    map_quality.write_dualmap(job.files("dualmap"), Path(job.output.objects))


def probes(job: Job) -> None:
    from ovman.analysis import probes as asked_again

    asked_again.write_probes(job.arm, job.file("episodes"), job.file("maps"), job.file("nouns"), job.settings, job.folder)


def sensitivity(job: Job) -> None:
    from ovman.analysis import probes as asked_again

    files = [job.file(name) for name in ("admissions", "episodes", "arm", "baseline")]
    asked_again.write_sensitivity(*files, job.settings, Path(job.output.sensitivity))


def tolerances(job: Job) -> None:
    from ovman.analysis import probes as asked_again

    files = [job.file(name) for name in ("trials", "released", "episodes", "arm", "baseline")]
    asked_again.write_tolerances(*files, job.settings, Path(job.output.tolerances))


def tables(job: Job) -> None:
    from ovman.report import tables as printed

    printed.write_paper_tables(job.files("metrics"), job.settings, Path(job.output.tables), job.files("notes"))


def split_tables(job: Job) -> None:
    from ovman.report import tables as printed

    printed.write_tables(job.files("metrics"), job.settings, Path(job.output.tables))


def relations(job: Job) -> None:
    from ovman.report.figures import relations as drawn_tours

    drawn_tours.draw_relations(job.files("episodes"), VISITS, job.settings, Path(job.output.relations))


def figures(job: Job) -> None:
    from ovman.report import figures as drawn

    drawn.draw_charts(job.files("metrics"), job.settings, job.folder)


def pages(job: Job) -> None:
    from ovman.report import results_page

    results_page.write_pages(job.files("metrics"), job.settings, job.folder)


run(snakemake, globals() | {"all_tables": split_tables})  # noqa: F821 (Snakemake defines it)
