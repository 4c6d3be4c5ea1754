"""Measure the cost of a step of the reimplemented CoW on one core.

    python bench/cow.py [--config config.yaml] [--scenes FloorPlan209 ...] [--walks 2] [--budget 250]

On floor plans outside the benchmark, CoW starts somewhere and searches for a category that is present until it stops or the
budget is spent. Each step is split into the frame (the engine and its client), the networks, and CoW itself: map, frontiers,
paths. Times are processor times; ratios compare numbers of this one run. The last table compares the numbers with their bounds.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from measure.bars import Bar, show
from measure.clock import processor, processor_s
from ovman import seeds
from ovman.agents.cow.agent import CowAgent
from ovman.agents.cow.localiser import make_localiser
from ovman.agents.interface import Action, CameraPose, Observation, Visit
from ovman.perception import networks
from ovman.perception.weights import WeightsError
from ovman.settings.config import load
from ovman.shipped import HOME as ROOT
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import AgentPose, Session
from ovman.task import Query, Relation

SCENES = ("FloorPlan209", "FloorPlan18", "FloorPlan326")
RUNS = 219 * 3
STEP_MS, SHARE = 50.0, 0.5
"""Bounds: milliseconds per step without frame and networks, and their ratio to frame and networks."""
FRAME, LOOK, OWN = "frame", "networks", "cow"
NOWHERE = CameraPose(0.0, 0.0, 0.0, 0.0, 0.0)


class Timed:
    """A localiser that measures its own time."""

    def __init__(self, inner: Any) -> None:
        self.inner, self.seconds = inner, 0.0

    def look_for(self, category: str) -> None:
        """See `Localiser`."""
        self.inner.look_for(category)

    def relevance(self, rgb: np.ndarray) -> np.ndarray:
        """See `Localiser`; measure the time."""
        began = processor_s(None)
        found = self.inner.relevance(rgb)
        self.seconds += processor_s(None) - began
        return found


def walk(session: Session, eyes: Any, settings: Any, budget: int, rng: np.random.Generator) -> tuple[int, dict[str, float]]:
    """Steps of one episode, and the processor seconds of each part."""
    session.reset()
    session.step("SetRandomSeed", seed=int(rng.integers(2**31)))
    categories = sorted({o["objectType"] for o in session.objects.values() if o["moveable"] or o["pickupable"]})
    places = sorted(session.reachable())
    x, z = places[rng.integers(len(places))]
    session.teleport(AgentPose(x, z, 30.0 * rng.integers(12)))
    session.filter_objects(())
    timed = Timed(eyes)
    agent = CowAgent(timed, settings.cow, settings.primitives)
    agent.familiarise(Visit((), np.empty((0, 2))))
    agent.ask(Query(categories[rng.integers(len(categories))], Relation.MOVED))
    engine = session._controller.server.unity_proc.pid
    spent = dict.fromkeys((FRAME, LOOK, OWN), 0.0)

    def took(what: str, work: Callable[[], Any]) -> Any:
        began = processor_s(engine)
        result = work()
        spent[what] += processor_s(engine) - began
        return result

    steps, action = 0, None
    took(FRAME, lambda: session.step("Pass", image=True))
    while steps < budget and action is not Action.STOP:
        seen = Observation(session.rgb, session.depth, NOWHERE, session.embodiment.field_of_view_deg)
        action, steps = took(OWN, lambda seen=seen: agent.act(seen)), steps + 1
        if action is not Action.STOP:
            took(FRAME, lambda action=action: session.step(action.value, image=True, allowed=True))
    spent[LOOK], spent[OWN] = timed.seconds, spent[OWN] - timed.seconds
    return steps, spent


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, default=ROOT / "config.yaml")
    parser.add_argument("--scenes", nargs="+", default=SCENES)
    parser.add_argument("--walks", type=int, default=2, help="of each scene")
    parser.add_argument("--budget", type=int, default=250)
    options = parser.parse_args()
    os.environ.setdefault("DISPLAY", ":0")
    os.environ.pop("CUDA_VISIBLE_DEVICES", None)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    settings: Any = load(options.config)
    names = ("cow, without frame and networks", "cow / (frame + networks)")
    try:
        eyes = make_localiser(settings, networks.detector_of(settings.perception), networks.encoder_of(settings.perception))
    except WeightsError as error:
        print(error)
        show([Bar(name, None, bar, unit) for name, bar, unit in zip(names, (STEP_MS, SHARE), ("ms", "x"), strict=True)])
        return
    print(f"{processor()}, one core")
    print(f"{'':24s}{'steps':>8s}" + "".join(f"{part + ', ms':>14s}" for part in (FRAME, LOOK, OWN)))
    counts, totals = [], []
    for scene in options.scenes:
        with Session(scene, settings, Embodiment.named("locobot", settings)) as session:
            for number in range(options.walks):
                steps, spent = walk(session, eyes, settings, options.budget, seeds.generator(0, "bench", scene, number))
                parts = np.array([spent[part] for part in (FRAME, LOOK, OWN)])
                print(
                    f"{scene + ', ' + str(number):24s}{steps:8d}" + "".join(f"{1e3 * t / steps:14.1f}" for t in parts), flush=True
                )
                counts.append(steps)
                totals.append(parts)
    frame, look, own = np.sum(totals, axis=0) / sum(counts) * 1e3
    mean = float(np.mean(counts))
    print(f"{'mean':24s}{mean:8.1f}{frame:14.1f}{look:14.1f}{own:14.1f}")
    episode_s = mean * (frame + look + own) / 1e3
    print(f"{episode_s:.2f} s an episode; {RUNS} like these would take {episode_s * RUNS:.0f} s")
    show([Bar(names[0], own, STEP_MS, "ms"), Bar(names[1], own / (frame + look), SHARE, "x")])


if __name__ == "__main__":
    main()
