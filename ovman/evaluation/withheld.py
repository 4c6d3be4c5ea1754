"""What an arm from which something is withheld is asked instead of an episode's query (`ovman.settings.arms.Withheld`).

Draws are of the episode and the run, not of the arm: agents from which the same is withheld are asked the same.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from ovman import seeds
from ovman.language.noun import noun
from ovman.language.vocabulary import SYNONYMS, nouns
from ovman.perception.labels import categories_of
from ovman.records.episode import Episode
from ovman.records.query import Query
from ovman.records.relation import Relation
from ovman.records.scene import Scene
from ovman.settings import Withheld

NO_NOUN = ""


def asked(episode: Episode, withheld: Withheld | None, run: int, categories: Collection[str] = ()) -> Query:
    """The query that an arm is given, by what is withheld from it.

    categories: of all instances of the episode's scene, for a wrong noun: it names something that can be in the maps, and has no
    noun of the vocabulary in common with the right one. A relation is drawn from all six: one drawn from the others would say
    which it is not. run: of the arm's runs. ValueError, in one line, where the scene has nothing else to name.
    """
    query = episode.query
    draws = seeds.generator(episode.provenance.seed, "withheld", str(withheld), episode.id, run)
    match withheld:
        case Withheld.NOUN:
            return Query(NO_NOUN, query.relation)
        case Withheld.NOUN_WRONG:
            others = _others(query.category, categories)
            if not others:
                raise ValueError(
                    f"{episode.id}: {episode.scene} has nothing but {noun(query.category)} to name; leave the arm out"
                )
            return Query(others[int(draws.integers(len(others)))], query.relation)
        case Withheld.RELATION:
            return Query(query.category, tuple(Relation)[int(draws.integers(len(Relation)))])
    return query


def _others(category: str, categories: Collection[str]) -> list[str]:
    """Those of `categories` that share no noun with `category`, sorted."""
    own = set(nouns(category))
    return sorted(other for other in {*categories} & SYNONYMS.keys() if not own & set(nouns(other)))


def categories_in(file: Path) -> frozenset[str]:
    """The categories of a scene's instances, of its record. RecordError in one line."""
    return frozenset(categories_of(Scene.parse(file.read_text(encoding="utf-8"), str(file))).values())
