"""An arm that needs detections is given those of the episode's visits, and nobody else is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ovman.agents.interface import Visit
from ovman.evaluation.context import EpisodeContext
from ovman.evaluation.observations import ObservationStore
from ovman.perception.records import Detected, write_detections, write_nouns
from ovman.settings import Kind, Need, Withheld
from ovman.settings.arms import ArmJob
from tests.episodes import released
from tests.runs import job

EPISODE = released()[0]
STAGE = job("two_visits")[1]
NAMES = (EPISODE.visits.first, EPISODE.visits.second)


def detected(count: int, content: str) -> Detected:
    masks = np.zeros((count, 4, 4), bool)
    masks[:, :2] = True
    return Detected(
        view=np.arange(count),
        point=np.ones((count, 3)),
        feature=np.eye(3, dtype=np.float32)[:count],
        pixels=np.full(count, 8),
        confidence=np.ones(count, np.float32),
        masks=lambda: masks,
        content=content,
    )


@pytest.fixture
def files(tmp_path) -> dict[str, Path]:
    write_detections(tmp_path / "detections.npz", {NAMES[0]: detected(1, "one"), NAMES[1]: detected(2, "two")})
    write_nouns(tmp_path / "nouns.npz", {EPISODE.noun: np.eye(3)[0]})
    return {name: tmp_path / f"{name}.npz" for name in ("detections", "nouns")}


class Store(ObservationStore):
    """Tours whose content is their name."""

    def _content(self, name: str) -> str:
        return f"shows {name}"


def store(files, *needs: Need, withheld: Withheld | None = None) -> Store:
    arm = ArmJob(name="mine", kind=Kind.STATIC, agent="a:b", needs=needs, withheld=withheld)
    return Store(arm, STAGE, 90.0, Path("no such directory"), files)


def context(of: Store) -> EpisodeContext:
    return EpisodeContext(np.random.default_rng(0), 0, STAGE, EPISODE, of._arm, of)


def test_a_visit_is_given_by_its_place_in_the_episode_and_by_what_it_shows(files):
    given = store(files, Need.DETECTIONS)
    assert [len(context(given).detections(which)) for which in ("first", "second")] == [1, 2]
    assert context(given).detections("second").masks().sum() == 16
    tours = [Visit((), np.zeros((0, 2)), f"shows {name}") for name in NAMES]
    assert [len(given.detections_in(tour)) for tour in tours] == [1, 2]
    with pytest.raises(ValueError, match=r"^no tour with the content unknown was looked at; make the stage detections again$"):
        given.detections_in(Visit((), np.zeros((0, 2)), "unknown"))


def test_an_answer_hangs_on_what_was_detected_in_the_visits_and_on_the_noun(files):
    key = store(files, Need.DETECTIONS).cache_key(NAMES, EPISODE.noun)
    assert key == {"detections": ["one", "two"], "noun": [1.0, 0.0, 0.0]}
