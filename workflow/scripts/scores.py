"""Stage `scores`: judges what an embodied arm did."""

from ovman.evaluation import scores
from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.run import Rollout
from ovman.workflow.job import job

with job(snakemake) as work:
    arm = work.constants.arm
    episodes = {episode.id: episode for episode in Episode.load(work.input("episodes"))}
    sources, outputs = work.inputs("rollouts"), work.outputs("scores")
    for output, files in zip(outputs, [sources] if len(outputs) == 1 else [[file] for file in sources], strict=True):
        runs = [scores.cut_rollout(run, arm) for file in files for run in Rollout.read(file)]
        output.write_text(lines(scores.score_rollout(run, episodes[run.episode], arm.any_instance) for run in runs))
