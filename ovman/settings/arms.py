"""The arms of the evaluation: section `arms` of config.yaml. Predictions, rollouts and rows of the tables are derived from it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from enum import StrEnum
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from ovman.section import Named, Section, Some, Word


class Kind(StrEnum):
    """The judgement of an arm: STATIC by its predicted point, EMBODIED by its stop."""

    STATIC = "static"
    EMBODIED = "embodied"


class Source(StrEnum):
    """Whether an arm finds something out itself (OWN) or is given the truth about it (HANDED)."""

    OWN = "own"
    HANDED = "handed"


class Reading(StrEnum):
    """The objects of its own map that an arm is told the noun means.

    MAJORITY: those most of whose detections truly show the category; ANY: those with one such detection; NEAREST: the object
    nearest to each true position, within the success radius; PLACES: every object within the success radius of a place at which
    either tour recorded the category, whichever visit the map is of.
    """

    MAJORITY = "majority"
    ANY = "any"
    NEAREST = "nearest"
    PLACES = "places"

    @property
    def by_position(self) -> bool:
        """Whether true positions decide, not what detections show."""
        return self in (Reading.NEAREST, Reading.PLACES)


class Need(StrEnum):
    """Inputs of an arm in addition to the query and its observations.

    TOURS: the recorded frames of both visits; MAPS: the maps that the reference agent's perception made of them, and the
    embeddings of nouns; MAINTAINED: its one map of both visits, and the embeddings of nouns; NETWORKS: the detector and the
    encoder themselves; DUALMAP: DualMap's maps, and the embeddings of nouns; DETECTIONS: what the detector found in the frames,
    and the embeddings of nouns; SEGMENTS: that with what both visits say of each one's place, and the embeddings of nouns; SCENE:
    the grid of the untouched scene, and for an arm that is given positions the looks of instances.
    """

    TOURS = "tours"
    MAPS = "maps"
    MAINTAINED = "maintained"
    NETWORKS = "networks"
    DUALMAP = "dualmap"
    DETECTIONS = "detections"
    SEGMENTS = "segments"
    SCENE = "scene"


class Withheld(StrEnum):
    """Parts of the query or the visits that are withheld from an arm (input ablation).

    NOUN: the query's category is ""; NOUN_WRONG: it is that of another thing in the scene; RELATION: the relation is drawn from
    all six; FIRST_VISIT, SECOND_VISIT: that tour showed nothing.
    """

    NOUN = "noun"
    NOUN_WRONG = "noun_wrong"
    RELATION = "relation"
    FIRST_VISIT = "first_visit"
    SECOND_VISIT = "second_visit"

    @property
    def visit(self) -> str | None:
        """The visit that is withheld, "first" or "second"."""
        return {Withheld.FIRST_VISIT: "first", Withheld.SECOND_VISIT: "second"}.get(self)


class Track(StrEnum):
    """The form of a query. PAPER: category and relation, with words; WORDS: a sentence and its noun phrase alone."""

    PAPER = "paper"
    WORDS = "words"


def _function(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*", value):
        raise ValueError(f'{value!r} names no function; write "package.module:function"')
    return value


def _name(value: str) -> str:
    if not re.fullmatch(r"[a-z][a-z0-9_]*", value):
        raise ValueError(f"{value!r} cannot name an arm, whose files are called after it; write small letters, digits and _")
    return value


Whence = Annotated[Source, Word]


class Arm(Section):
    """One arm of the evaluation."""

    name: Annotated[str, AfterValidator(_name)] = Field(description="the key of its entry, in file names and records")
    kind: Annotated[Kind, Word] = Field(description="judged by the point that it predicts, or by where it stops")
    agent: Annotated[str, AfterValidator(_function)] = Field(description='"module:function" (docs/agents.md)')
    system: str = Field(min_length=1, description='title of its row; an embodied arm\'s "agent"')
    memory: str = Field(min_length=1, description="what it keeps of the two visits, in the tables")
    grounding: Whence = Field(Source.OWN, description="whether it finds out itself what the noun means")
    reading: Annotated[Reading, Word] = Field(Reading.MAJORITY, description="objects that a handed noun means")
    positions: Whence = Field(Source.OWN, description="whether it finds out itself where things are")
    answer: Whence = Field(Source.OWN, description="handed to the oracle only")
    control: bool = Field(False, description="a control, not a system; the tables show it apart")
    ablates: str | None = Field(None, description="the arm of which it lacks a part; it stands apart in the tables")
    blind: Literal["noun", "relation", "visit"] | None = Field(
        None, description="what its answer does not depend on; the table of bounds compares it with chance"
    )
    on_main: bool = Field(True, description="whether it answers split main, if that lists no arms of its own")
    track: Annotated[Track, Word] = Field(Track.PAPER, description="words: it gets a sentence and its noun phrase alone")
    withheld: Annotated[Withheld, Word] | None = Field(None, description="what a static arm is not given")
    needs: tuple[Annotated[Need, Word], ...] = Field((), description="what it is given in addition to query and observations")
    constants: tuple[str, ...] = Field((), description='settings that it reads, "section.name" or "section.*"')
    executes: str | None = Field(None, description="the static arm whose predictions an embodied arm drives to")
    expected: bool = Field(False, description="its static success is the expectation over a stochastic pick")
    runs: Some = Field(1, description="runs of a static arm over all episodes; its rates are their means")
    embodiment: Literal["default", "locobot"] = Field("default", description="body and camera of an embodied arm")
    made_by: str | None = Field(None, description="the plug-in whose rules make its records, which may be empty")
    any_instance: bool = Field(False, description="its own task is to reach any instance; it is judged on that, too")
    budget: Some | None = Field(None, description="actions; primitives.action_budget if not given")
    cut_from: str | None = Field(None, description="the embodied arm whose runs, ended after `budget` actions, are its own")

    @property
    def reads_labels(self) -> bool:
        """Whether it is given what the detections of its map truly show."""
        handed = self.grounding is Source.HANDED and self.answer is Source.OWN
        detects = self.positions is Source.OWN or Need.DETECTIONS in self.needs
        return handed and detects and self.kind is Kind.STATIC and not self.reading.by_position

    @property
    def reads_sightings(self) -> bool:
        """Whether it is given what the tours truly recorded. An arm that is given the answer has no use for it."""
        handed = self.answer is not Source.HANDED and Source.HANDED in (self.grounding, self.positions)
        return handed and not (self.reads_labels and self.positions is Source.OWN)

    @property
    def reads_scenes(self) -> bool:
        """Whether it is given records of untouched scenes, or a noun from them."""
        return Need.SCENE in self.needs or self.withheld is Withheld.NOUN_WRONG

    @property
    def embeds_phrases(self) -> bool:
        """Whether it may be asked for a phrase that is not a noun of the vocabulary, so that the encoder embeds it."""
        return Need.NETWORKS in self.needs or self.track is Track.WORDS

    @property
    def answers_once(self) -> bool:
        """Whether it is a static arm whose prediction for an episode is one answer to the episode's own question."""
        return self.kind is Kind.STATIC and not self.expected and self.runs == 1 and self.withheld is None


WORDS = ("system", "memory", "control", "ablates", "blind", "on_main")
"""Fields that only the tables show. A job of an arm does not get them, so that a new title reruns nothing but the tables."""


class ArmJob(Arm):
    """An arm as one of its jobs is given it, without the words of the tables.

    marks: the budgets at which other arms cut this one's runs, ascending; executed: the arm that it executes.
    """

    system: str = ""
    memory: str = ""
    marks: tuple[int, ...] = ()
    executed: ArmJob | None = None


Arms = Annotated[dict[str, Arm], Named]
"""By name, in the order of the tables."""


def arms_of(arms: Mapping[str, Arm]) -> tuple[Arm, ...]:
    """Return all arms in the order of config.yaml, which is that of the tables."""
    return tuple(arms.values())


def of_kind(arms: Iterable[Arm], kind: Kind) -> tuple[Arm, ...]:
    """Return the arms of one kind, in their order."""
    return tuple(arm for arm in arms if arm.kind is kind)


def other_readings(arms: Iterable[Arm]) -> frozenset[str]:
    """Return the names of the arms that differ from an earlier one in nothing but the reading: they have a table of their own."""
    found, met = set(), set[str]()
    for arm in arms:
        entry = arm.model_dump_json(exclude={"name", "reading"})
        if entry in met:
            found.add(arm.name)
        met.add(entry)
    return frozenset(found)
