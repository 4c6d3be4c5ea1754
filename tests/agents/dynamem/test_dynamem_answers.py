"""What DynaMem's memory answers: by hand, and on tours of a real scene in which a chair was moved."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from ovman.agents.dynamem import agent
from ovman.agents.dynamem.agent import locate, map_noun, predict_current, predict_two_visits
from ovman.agents.dynamem.memory import Look, Memory, look_at_tour, remember, remember_tours
from ovman.agents.interface import Abstention, AbstentionReason, Action, Answer, CameraPose, Observation, Query, Relation, Visit
from ovman.agents.pilot import Pilot
from ovman.perception.backprojection import Camera
from ovman.records.prediction import as_recorded
from tests.agents.moved_chair import home as made
from tests.arms import CONFIG

SETTINGS = CONFIG
CONSTANTS, RADIUS_M = SETTINGS.dynamem, CONFIG.success.radius_m
MUG, LAMP, NEITHER = np.eye(3)
NOTHING = Abstention(AbstentionReason.NOTHING_GROUNDED)


def memory(*voxels: tuple[float, float, np.ndarray, int]) -> Memory:
    """Voxels by x, z, feature and frame, a metre above the floor."""
    point = np.array([(x, 1.0, z) for x, z, _, _ in voxels])
    feature, seen = np.array([one for _, _, one, _ in voxels]), np.array([one for *_, one in voxels])
    number = np.arange(len(voxels))
    return Memory(number, point, np.ones(len(voxels)), seen, number, feature)


def frame(*seen: tuple[tuple[float, float], np.ndarray, float]) -> Look:
    """Detections by place, feature and nearest depth."""
    places = np.array([(x, 1.0, z) for (x, z), _, _ in seen]).reshape(-1, 3)
    camera, nothing = Camera((0.0, 1.5, 0.0), 0.0, 0.0, 90.0), np.zeros((2, 2))
    features, nearest = np.array([one for _, one, _ in seen]).reshape(-1, 3), np.array([one for *_, one in seen])
    return Look(nothing, camera, nothing > 0, np.zeros((0, 3)), np.zeros(0, np.int64), features, places, nearest)


def unlike(cosine: float) -> np.ndarray:
    """A unit feature of that cosine to the mug."""
    return np.array([cosine, 0.0, math.sqrt(1 - cosine**2)])


LESS, MORE = unlike(CONSTANTS.similarity - 0.01), unlike(CONSTANTS.similarity + 0.01)


def test_the_best_voxel_names_the_frame_whose_best_detection_is_the_answer():
    found = memory((0.0, 0.0, MORE, 0), (5.0, 5.0, MUG, 1))
    frames = [frame(((0.1, 0.0), MUG, 1.0)), frame(((5.2, 5.0), MORE, 1.0), ((5.4, 5.0), MUG, 1.0), ((9.0, 9.0), LAMP, 1.0))]
    assert locate(found, frames, MUG, CONSTANTS) == Answer(5.4, 5.0)
    assert locate(found, [frames[0], frame()], MUG, CONSTANTS) == Answer(5.0, 5.0)
    far = frame(((5.4, 5.0), MUG, CONSTANTS.detected_m))
    assert locate(found, [frames[0], far], MUG, CONSTANTS) == Answer(5.0, 5.0)


def test_what_is_like_the_noun_too_little_is_no_answer():
    dim = memory((0.0, 0.0, LESS, 0))
    assert locate(dim, [frame()], MUG, CONSTANTS) == NOTHING
    assert locate(dim, [frame(((1.0, 1.0), LESS, 1.0))], MUG, CONSTANTS) == NOTHING
    assert locate(dim, [frame(((1.0, 1.0), MORE, 1.0))], MUG, CONSTANTS) == Answer(1.0, 1.0)
    assert locate(memory((0.0, 0.0, MORE, 0)), [frame()], MUG, CONSTANTS) == Answer(0.0, 0.0)
    assert locate(Memory.empty(), [], MUG, CONSTANTS) == NOTHING


def test_the_length_of_a_mean_feature_is_of_no_consequence():
    short = memory((0.0, 0.0, 0.2 * MUG, 0), (3.0, 0.0, MORE, 0))
    assert locate(short, [frame()], MUG, CONSTANTS) == Answer(0.0, 0.0)


def test_objects_are_groups_of_neighbouring_voxels_that_the_noun_means():
    reach = CONSTANTS.cluster_voxels * CONSTANTS.voxel_m
    one, other = [(reach * 0.9 * k, 0.0, MUG, k) for k in range(4)], [(9.0, reach * 0.9 * k, MUG, 7) for k in range(3)]
    objects = map_noun(memory(*one, *other, (4.0, 4.0, LAMP, 9)), MUG, 0.03, CONSTANTS)
    assert np.allclose(objects.p[np.argsort(objects.p[:, 0])], [(reach * 1.35, 0.0), (9.0, reach * 0.9)])
    assert sorted(objects.last_seen) == [3, 7] and np.allclose(objects.f, MUG)
    assert [track.shape for track in objects.tracks] == [(1, 2)] * 2
    assert not len(map_noun(Memory.empty(), MUG, 0.03, CONSTANTS))


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return made(tmp_path_factory)


class Context:
    """The tours of a home, and its chair as the noun."""

    settings = SETTINGS

    def __init__(self, home, first="before", second="after"):
        self._tours, self._chair = {"first": getattr(home, first), "second": getattr(home, second)}, home.chair

    def tour(self, which):
        return self._tours[which].visit

    def detections(self, which):
        return self._tours[which].detected

    def noun(self, phrase):
        assert phrase == "chair"
        return self._chair


def off(found: Answer | Abstention, at: tuple[float, float]) -> float:
    return math.dist((found.x, found.z), at) if isinstance(found, Answer) else math.inf


def test_in_a_real_scene_the_memory_of_both_tours_holds_the_new_place_of_a_chair_alone(home):
    frames = [frame for one in (home.before, home.after) for frame in look_at_tour(one.visit, one.detected, CONSTANTS)]

    def places(memory: Memory) -> np.ndarray:
        return memory.point[memory.feature @ home.chair > 0.5][:, [0, 2]]

    def near(memory: Memory, place: tuple[float, float]) -> int:
        return int(np.count_nonzero(np.hypot(*(places(memory) - place).T) < RADIUS_M))

    before, both = remember(frames[: len(home.before.visit.observations)], CONSTANTS), remember(frames, CONSTANTS)
    assert near(before, home.old) > CONSTANTS.cluster_points and near(before, home.new) == 0
    assert near(both, home.new) > CONSTANTS.cluster_points and near(both, home.old) <= 0.1 * near(before, home.old)


def test_in_a_real_scene_a_memory_of_both_tours_goes_on_from_that_of_the_first(home):
    seen = [(one.visit, one.detected) for one in (home.before, home.after)]
    both, frames = remember_tours(seen, CONSTANTS)
    once = remember([frame for visit, detected in seen for frame in look_at_tour(visit, detected, CONSTANTS)], CONSTANTS)
    assert len(frames) == sum(len(visit.observations) for visit, _ in seen)
    assert all(np.array_equal(getattr(both, name), getattr(once, name)) for name in Memory.__slots__)


def test_in_a_real_scene_a_memory_of_each_visit_tells_the_places_apart(home):
    for relation, place in ((Relation.MOVED, home.new), (Relation.FORMER, home.old)):
        assert off(predict_two_visits(Query("Chair", relation), Context(home))[0], place) < RADIUS_M
    again = Context(home, "before", "before")
    assert off(predict_two_visits(Query("Chair", Relation.STABLE), again)[0], home.old) < RADIUS_M
    assert isinstance(predict_two_visits(Query("Chair", Relation.MOVED), again)[0], Abstention)


def test_the_embodied_arm_drives_to_the_static_answer_and_abstains_without_one(home):
    went = []

    class Recording(Pilot):
        def act(self, observation, goal):
            went.append(goal)
            return Action.STOP

    class Driving(Context):
        pilot, answered = Recording(CONFIG.primitives, np.random.default_rng(0)), None

        def detections(self, visit):
            return next(one.detected for one in self._tours.values() if one.visit is visit)

    def driven(context, *visits: Visit) -> Action:
        driver = agent.agent(context)
        driver.familiarise(visits[0])
        driver.revisit(visits[1])
        driver.ask(Query("Chair", Relation.MOVED))
        return driver.act(Observation(None, None, CameraPose(0.0, 1.5, 0.0, 0.0, 0.0), 90.0))

    assert driven(Driving(home), home.before.visit, home.after.visit) is Action.STOP
    answer = as_recorded(predict_current(Query("Chair", Relation.MOVED), Context(home))[0])
    assert went == [(answer.x, answer.z)] and agent.DynamemAgent.looks is False
    empty = Driving(home)
    empty._chair = np.zeros_like(home.chair)
    assert driven(empty, home.before.visit, home.after.visit) is Action.ABSTAIN


def test_a_tour_without_depth_is_one_line(home):
    blind = tuple(replace(one, depth=None) for one in home.before.visit.observations[:1])
    with pytest.raises(ValueError, match=r"^DynaMem reads depth; write needs: \[tours, detections\] in its entry$"):
        look_at_tour(Visit(blind, home.before.visit.reachable), home.before.detected, CONSTANTS)
