"""OVMAN-v1 is an environment as Gymnasium wants it, and tells no truth before the end of a run."""

from __future__ import annotations

import warnings
from dataclasses import astuple

import gymnasium
import numpy as np
import pytest
from gymnasium.error import InvalidAction, ResetNeeded
from gymnasium.utils.env_checker import check_env, data_equivalence

import ovman.gym
from ovman.agents.interface import Action
from ovman.gym.spaces import ACTIONS, CATEGORIES, INSTRUCTION, RELATIONS
from ovman.records.episode import Episode
from ovman.records.task import Relation
from tests.arms import CONFIG
from tests.episodes import DATA, of_scene

FORWARD, LEFT, RIGHT, STOP, ABSTAIN = map(
    ACTIONS.index, (Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.ROTATE_RIGHT, Action.STOP, Action.ABSTAIN)
)
HERE = {"pose", "last_action_succeeded", "reachable", "reachable_count", "reachable_anew", "relation", "category"}
PICTURES = {"rgb", "depth"}
TOLD = {"episode", "scene", "seed", "category", "relation", "sentence", "phrase", "field_of_view_deg"}
TOURS = {f"{which}_{part}" for which in ("first", "second") for part in ("rgb", "depth", "pose")}
SCENE = "FloorPlan10"
MOVING = next(episode for episode in reversed(of_scene("FloorPlan7")) if episode.relation is Relation.MOVING)


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """A file of two episodes of one scene."""
    path = tmp_path_factory.mktemp("episodes") / "two.jsonl"
    path.write_text("".join(episode.to_line() for episode in of_scene(SCENE)[:2]))
    return path


@pytest.fixture
def made(tours, two):
    """Makes environments, of two episodes where nothing is said, and closes them."""
    every = []

    def make(**options):
        every.append(gymnasium.make(ovman.gym.ID, **({"episodes": two, "cache": tours} | options)))
        return every[-1]

    yield make
    for env in every:
        env.close()


@pytest.fixture(scope="module")
def small(tours, two):
    """An environment without pictures, in which a step is quick."""
    with gymnasium.make(ovman.gym.ID, episodes=two, cache=tours, looks=False, tours="reset") as env:
        yield env


def test_gymnasium_finds_nothing_to_say(made):
    """Without pictures, which take long and which test_an_observation_is_what_an_agent_is_told checks."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        check_env(made(looks=False, tours="reset").unwrapped, skip_render_check=True)


def test_a_split_is_its_episodes_in_the_spaces_of_the_page():
    """Nothing is started to know them."""
    env = gymnasium.make("OVMAN-v1", split="dev")
    assert env.unwrapped.episode_ids == tuple(episode.id for episode in Episode.load(DATA / "episodes" / "dev.jsonl"))
    assert env.action_space == gymnasium.spaces.Discrete(5) and len(ACTIONS) == len(Action)
    assert set(env.observation_space) == HERE | PICTURES | TOURS
    for key, shape in {"rgb": (300, 300, 3), "first_depth": (24, 300, 300), "second_pose": (24, 5)}.items():
        assert env.observation_space[key].shape == shape
    env.close()


def test_an_observation_is_what_an_agent_is_told(made):
    env = made(render_mode="rgb_array")
    seen, _ = env.reset(seed=3, options={"episode": of_scene(SCENE)[0].id})
    assert seen in env.observation_space
    run = env.unwrapped._begun
    assert (CATEGORIES[seen["category"]], RELATIONS[seen["relation"]]) == (run.episode.category, run.episode.relation)
    assert np.array_equal(seen["rgb"], env.render()) and seen["depth"].dtype == np.float32
    assert seen["pose"][0] == run.episode.spawn.x and not seen["reachable"][seen["reachable_count"] :].any()
    for which in ("first", "second"):
        for number, view in enumerate(run.tour(which, np.empty((0, 2))).observations):
            assert seen[f"{which}_pose"][number].tolist() == [*astuple(view.pose)]
            assert np.array_equal(seen[f"{which}_rgb"][number], view.rgb)
            assert np.array_equal(seen[f"{which}_depth"][number], view.depth)
    kept = seen["first_depth"].copy()
    seen["first_depth"][:] += 1  # what it keeps is its own
    seen["rgb"][:] = 0
    again, *_ = env.step(LEFT)
    assert np.array_equal(again["first_depth"], kept) and again["rgb"].any()


def walked(env, seed, episode, actions):
    """All that a run tells, the reset first."""
    told = [env.reset(seed=seed, options={"episode": episode})]
    return told + [env.step(action) for action in actions]


WALK = [FORWARD, LEFT, FORWARD, FORWARD, RIGHT, FORWARD, STOP]


def test_a_seed_says_all(made, tmp_path, tours):
    (tmp_path / "moving.jsonl").write_text(MOVING.to_line())
    env = made(episodes=tmp_path / "moving.jsonl", looks=False, tours="reset")
    once = walked(env, 7, MOVING.id, WALK)
    assert data_equivalence(once, walked(env, 7, MOVING.id, WALK), exact=True)
    assert any(seen["reachable_anew"] for seen, *_ in once[1:])
    others = [walked(env, seed, MOVING.id, WALK)[-1][0] for seed in (8, 9)]
    assert not all(data_equivalence(once[-1][0], other, exact=True) for other in others), "movers draw by the seed"


def test_without_a_seed_runs_follow_from_the_last_one(small):
    def drawn():
        return [small.reset(seed=seed)[1] for seed in (5, None, None)]

    first, second = drawn(), drawn()  # each episode comes once before any comes again
    assert data_equivalence(first, second, exact=True) and len({info["seed"] for info in first}) == 3
    assert {info["episode"] for info in first} == set(small.unwrapped.episode_ids)


def numbers(told):
    """All numbers of what is told, rounded as records are."""
    if isinstance(told, dict):
        return {number for value in told.values() for number in numbers(value)}
    if isinstance(told, (tuple, list)):
        return {number for value in told for number in numbers(value)}
    if isinstance(told, np.ndarray) and told.ndim < 3:
        return set(np.round(told, 4).ravel().tolist())
    return {round(told, 4)} if isinstance(told, float) else set()


@pytest.mark.parametrize("which", [0, 1])
def test_nothing_is_told_of_the_answer_before_the_end(small, made, tmp_path, which):
    """Neither is it among the numbers, nor does anything change with what the evaluator knows."""
    episode = of_scene(SCENE)[which]
    told = walked(small, 0, episode.id, WALK)
    (first, info), *steps = told
    assert set(info) == TOLD | TOURS and set(first) == HERE
    assert [set(more) for *_, more in steps[:-1]] == [set()] * (len(WALK) - 1)
    assert set(steps[-1][-1]) == {"is_success", "spl", "outcome", "actions", "path_length_m"}
    assert [(reward, over, spent) for _, reward, over, spent, _ in steps[:-1]] == [(0.0, False, False)] * (len(WALK) - 1)
    assert steps[-1][2:4] == (True, False) and steps[-1][1] == float(steps[-1][-1]["is_success"])
    assert not {*episode.answer, episode.shortest_path_m} & numbers([(first, info), *steps[:-1]])
    x, z = episode.answer
    moved = {"answer": {"x": x + 0.1, "z": z}, "shortest_path_m": episode.shortest_path_m + 1}
    (tmp_path / "other.jsonl").write_text(Episode.from_json(episode.to_json() | moved, "other").to_line())
    other = walked(made(episodes=tmp_path / "other.jsonl", looks=False, tours="reset"), 0, episode.id, WALK)
    assert data_equivalence(told[:-1], other[:-1], exact=True) and data_equivalence(told[-1][0], other[-1][0], exact=True)


PRIMITIVES = of_scene(SCENE)[0].protocol.primitives
ROUND = [FORWARD] + [LEFT] * round(180 / PRIMITIVES.turn_deg)
ENDS = {
    "abstained": [ABSTAIN],
    "stalled": [LEFT] * PRIMITIVES.stall_after,
    "budget": (ROUND * PRIMITIVES.action_budget)[: PRIMITIVES.action_budget],  # to and fro, so that it does not stall
}


@pytest.mark.parametrize("outcome", ENDS)
def test_runs_end_as_the_benchmark_ends_them_and_a_spent_budget_truncates(small, outcome):
    *before, (_, reward, over, spent, info) = walked(small, 0, of_scene(SCENE)[0].id, ENDS[outcome])[1:]
    assert not any(over or spent for _, _, over, spent, _ in before)
    assert (info["outcome"], reward, info["is_success"]) == (outcome, 0.0, False)
    assert (over, spent) == (outcome != "budget", outcome == "budget") and len(small.unwrapped.run.trace) == len(ENDS[outcome])


def test_what_cannot_be_done_is_said(small):
    bare = small.unwrapped
    bare.reset(seed=0)
    for action in (5, -1, 99):
        with pytest.raises(InvalidAction, match=f"{action} is not an action; the actions are 0 to 4"):
            bare.step(action)
    assert bare.run is None and not bare.step(np.int64(LEFT))[2], "the run goes on"
    bare.step(STOP)
    with pytest.raises(ResetNeeded, match="call reset"):
        bare.step(LEFT)
    assert bare.run.trace == "LS"
    for options, said in [
        ({"floor": 1}, "floor is not an option"),
        ({"episode": "x"}, "'x' is not among"),
    ]:
        with pytest.raises(ValueError, match=said):
            bare.reset(options=options)


def test_it_can_be_closed_at_any_moment_and_used_again(made):
    bare = made(looks=False, tours="reset").unwrapped
    with pytest.raises(ResetNeeded):
        bare.step(LEFT)
    seen, _ = bare.reset(seed=1)
    bare.close()
    bare.close()
    with pytest.raises(ResetNeeded):
        bare.step(LEFT)
    assert data_equivalence(bare.reset(seed=1)[0], seen, exact=True)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"split": "dev", "episodes": "absent.jsonl"}, "split and episodes exclude each other"),
        ({"scenes": ["FloorPlan6"]}, f"scenes: FloorPlan6 has no episode; write some of {SCENE}"),
        ({"name": CONFIG.comparisons.agent}, "does not drive from episodes and tours alone"),
        ({"name": next(name for name, arm in CONFIG.arms.items() if arm.reads_sightings)}, "name: "),
        ({"tours": "never"}, "tours: 'never' is no place"),
        ({"render_mode": "ansi"}, "render_mode: 'ansi' cannot be rendered"),
    ],
)
def test_a_wrong_environment_is_one_line(made, options, said):
    with warnings.catch_warnings(), pytest.raises((ValueError, OSError), match=said) as refused:
        warnings.simplefilter("ignore", UserWarning)
        made(**({"episodes": None} if "split" in options else {}) | options)
    assert "\n" not in str(refused.value)


def test_relations_have_numbers_that_stay():
    """Whoever trains on them relies on it."""
    assert [str(relation) for relation in RELATIONS] == ["moved", "former", "moving", "stable", "appeared", "removed"]
    assert len(CATEGORIES) == 118 and [CATEGORIES.index(name) for name in ("AlarmClock", "Chair", "Window")] == [0, 22, 116]
    assert [action.name for action in ACTIONS] == ["MOVE_AHEAD", "ROTATE_LEFT", "ROTATE_RIGHT", "STOP", "ABSTAIN"]


def test_in_the_words_track_there_is_neither_category_nor_relation(made):
    env = made(looks=False, tours="reset", track="words")
    observation, told = env.reset(seed=0)
    assert set(observation) == HERE - {"relation", "category"} == set(env.observation_space)
    assert not {"relation", "category"} & set(told) and told["phrase"] in told["sentence"]
    assert INSTRUCTION.contains({name: told[name] for name in INSTRUCTION})
    assert env.step(STOP)[2]
    with pytest.raises(ValueError, match="^track: 'speech' is not a track; write one of paper, words$"):
        made(track="speech")
