"""The process in which CoW's released runner works, with the Python of its own environment.

`python -m ovman_released.cow_process JOB.json`; JOB.json is a `Job`. The runner writes one file an episode into `results`,
the test at the stop one line an episode into `verdicts`. Needs numpy, ai2thor and what the released code needs; of what this
package requires nothing else.
"""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Any

from ovman.records.episode import Episode
from ovman.sim.controller import launched
from ovman_released import cow_shims
from ovman_released.cow_controller import EpisodeController, Verdict
from ovman_released.cow_episodes import exported, runner_name, vocabulary
from ovman_released.plugin import ReleasedCow

RUNNER, AGENT, LOCALIZATION = "robothor_challenge", "src.models.agent_fbe_owl", "src.models.localization.clip_owl"
PROMPTS, SETTINGS = Path("prompt_templates", "imagenet_template.json"), Path("config_cow.yaml")
SIZE = ("width", "height")
_PLACES = ("root", "results", "verdicts")


@dataclass(frozen=True)
class Job:
    """One call of the released runner.

    root: of the clone; results, verdicts: where to write; settings: section `released_cow`; seed: the runner's; episodes: in
    their order.
    """

    root: Path
    results: Path
    verdicts: Path
    settings: ReleasedCow
    seed: int
    episodes: tuple[Episode, ...]

    def write(self, path: Path) -> None:
        """Write the call to a file, as plain JSON."""
        places = {name: str(getattr(self, name)) for name in _PLACES}
        episodes = [episode.to_json() for episode in self.episodes]
        record = {**places, "settings": self.settings.model_dump(mode="json"), "seed": self.seed, "episodes": episodes}
        path.write_text(json.dumps(record) + "\n", encoding="utf-8")

    @staticmethod
    def load(path: Path) -> Job:
        """The call of a file."""
        given = json.loads(path.read_text(encoding="utf-8"))
        root, results, verdicts = (Path(given[name]) for name in _PLACES)
        episodes = tuple(Episode.from_json(episode, str(path)) for episode in given["episodes"])
        return Job(root, results, verdicts, ReleasedCow.model_validate(given["settings"]), int(given["seed"]), episodes)


class _Results:
    """The runner's queue of results, which are in its files as well."""

    def put(self, result: Sequence[Any]) -> None:
        print(f"{result[0]}: done", flush=True)


def run(job: Job) -> None:
    """One pass of the unmodified runner over the episodes, with one agent, in their order."""
    cow_shims.stand_in_for_lost_modules()
    sys.path.insert(0, str(job.root))
    os.chdir(job.root)
    cow_shims.drop_outgrown_override(import_module(LOCALIZATION))
    factory, runner = import_module(AGENT), import_module(RUNNER)
    cow_shims.start_no_display(runner)
    cow_shims.allow_absent_targets(runner)
    original = runner.ai2thor.controller.Controller
    job.results.mkdir(parents=True, exist_ok=True)
    with job.verdicts.open("w", encoding="utf-8") as verdicts:

        def judged(verdict: Verdict) -> None:
            verdicts.write(verdict.to_line())
            verdicts.flush()

        episodes = {runner_name(episode): episode for episode in job.episodes}
        (backend,) = {episode.backend for episode in job.episodes}
        launch = partial(launched, original, backend)
        cow_shims.start_with(runner, partial(EpisodeController, launch, episodes, job.seed, judged))
        _call(job, factory, runner)


def _call(job: Job, factory: Any, runner: Any) -> None:
    settings = job.settings
    kinds = {name: type(signature(factory.build).parameters[name].default) for name in ("env_type", "class_type")}
    world = {"env_type": kinds["env_type"].NORMAL, "class_type": kinds["class_type"].REGULAR}
    agent, arguments, depth = factory.build(
        fail_stop=True,
        prompts_path=str(job.root / PROMPTS),
        threshold=settings.threshold,
        device_num=0 if settings.device == "cuda" else -1,
        center_only=True,
        **world,
    )
    # The released lists are of the same length where there are any; names of categories that it knows stay its own.
    known = dict(zip(arguments.get("classes") or (), arguments.get("classes_clip") or (), strict=False))
    names = vocabulary([episode.category for episode in job.episodes], known)
    arguments["classes"], arguments["classes_clip"] = names
    waiting: queue.Queue[dict[str, Any]] = queue.Queue()
    for episode in job.episodes:
        waiting.put(exported(episode))
    runner.RobothorChallenge.inference_worker(
        worker_ind=0,
        in_queue=waiting,
        out_queue=_Results(),
        agent_class=agent,
        agent_kwargs=arguments,
        controller_kwargs=parameters(job.root / SETTINGS) | {"renderDepthImage": bool(depth)},
        max_steps=settings.budget,
        test=False,
        device=_device(settings.device),
        class_remap=None,
        experiment_name=str(job.results),
        no_grad=True,
        seed=job.seed,
        **world,
    )


def parameters(settings: Path) -> dict[str, Any]:
    """The Controller's parameters of the released configuration: its body, its camera, its step. ValueError without a size."""
    import yaml

    read = yaml.safe_load(settings.read_text(encoding="utf-8"))
    given = dict(read["initialize"]) | {name: read[name] for name in SIZE if name in read}
    if lost := [name for name in SIZE if name not in given]:
        raise ValueError(f"{settings}: has no {' and no '.join(lost)}; check out the released code again")
    return given


def _device(name: str) -> Any:
    return import_module("torch").device("cuda:0" if name == "cuda" else "cpu")


def _end_with_parent() -> None:
    """End when the other end of standard input closes: an orphaned run must not go on."""

    def wait() -> None:
        while os.read(0, 1):
            pass
        print("the released runner is ended, because the process that waits for it has ended", file=sys.stderr, flush=True)
        os._exit(1)

    threading.Thread(target=wait, name="end-with-parent", daemon=True).start()


if __name__ == "__main__":
    _end_with_parent()
    run(Job.load(Path(sys.argv[1])))
