"""No two episodes are seen in the same pair of tours; every pair that was certified serves one relation."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ovman.generation.selection import find_sharing, select_independent
from ovman.records.task import Relation

CAME, WENT, ELSE = Relation.APPEARED, Relation.REMOVED, Relation.MOVED
CLAIMS = st.lists(st.tuples(st.sampled_from("AB"), st.sampled_from([(CAME,), (WENT,), (CAME, WENT), (ELSE,)])), max_size=14)


def drawn(claims):
    """Trials by claims: one trial a relation of every pair of tours; the pairs and the relations by id."""
    pairs, relation_of = {}, {}
    for number, (scene, relations) in enumerate(claims):
        for relation in relations:
            key = f"{scene}/{relation.value}/{number:04d}"
            pairs[key], relation_of[key] = (scene, frozenset(("untouched", str(number)))), relation
    return pairs, relation_of


@given(CLAIMS, st.integers(0, 9), st.integers(0, 9), st.integers(0, 5))
def test_every_pair_serves_one_trial_and_both_relations_have_enough_where_that_is_possible(claims, came, went, seed):
    pairs, relation_of = drawn(claims)
    wanted = dict.fromkeys(Relation, 0) | {CAME: came, WENT: went}
    kept = select_independent(pairs, relation_of, wanted, np.random.default_rng(seed))
    assert kept == sorted(kept) and len({pairs[k] for k in kept}) == len(kept) == len(set(pairs.values()))
    alone, either = ([c for _, c in claims].count((r,)) for r in (CAME, WENT)), [c for _, c in claims].count((CAME, WENT))
    lacking = sum(max(0, wish - has) for wish, has in zip((came, went), alone, strict=True))
    has = [sum(relation_of[k] is r for k in kept) for r in (CAME, WENT)]
    assert (has[0] >= came and has[1] >= went) == (lacking <= either)
    shuffled = {k: pairs[k] for k in sorted(pairs, reverse=True)}
    assert select_independent(shuffled, relation_of, wanted, np.random.default_rng(seed)) == kept


@given(CLAIMS, st.data())
def test_what_is_left_out_shares_its_tours_with_what_is_released(claims, data):
    pairs, relation_of = drawn(claims)
    kept = select_independent(pairs, relation_of, dict.fromkeys(Relation, 3), np.random.default_rng(0))
    released = [k for k in kept if data.draw(st.booleans())]
    out = find_sharing(pairs, released)
    assert not {*out} & {*released}
    assert {pairs[k] for k in out} <= {pairs[k] for k in released}
    assert not {pairs[k] for k in pairs if k not in out and k not in released} & {pairs[k] for k in released}
