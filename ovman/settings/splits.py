"""Section `splits`: what each split releases, and in what it differs from the paper's protocol."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from ovman.section import Count, Distinct, Metres, Named, Section, Some, Whole
from ovman.settings.benchmark import Level, PerRelation, Scene

MAIN = "main"
"""The split that is always there. Random streams, ids and files of metrics do not have its name."""
NAME = r"[a-z]+(_[a-z]+)*"
"""Names of splits."""
NONE = PerRelation(moved=0, former=0, moving=0, stable=0, appeared=0, removed=0)
TAKEN = frozenset({"static", "embodied"})
"""Names that files of metrics have already."""


class Crossed(Section):
    """World pairs: several things change at once, and every query that the changes define is asked (docs/crossed.md)."""

    queries: tuple[Some, ...] = Field(min_length=2, max_length=2, description="fewest and most of them in a world pair")
    apart_m: Metres = Field(description="metres, from an answer to every other place of a change or of an instance of the noun")
    pairs: Some = Field(1, description="world pairs per scene, at most")

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        fewest, most = self.queries
        if fewest > most:
            raise ValueError(f"queries is {list(self.queries)}; write the fewest before the most")
        return self


class Homes(Section):
    """Homes that are drawn from a seed (ovman/homes)."""

    seed: Count = Field(description="other seeds give other homes")
    count: Some = Field(description="number of homes")
    rooms: Annotated[tuple[Literal[1, 2, 3], ...], Field(min_length=1)] = Field(description="numbers of rooms, in turn")
    assets: Literal["train", "val", "test"] = Field(description="ProcTHOR's split of the assets that furnish them")

    @property
    def stems(self) -> tuple[str, ...]:
        """How the names of the homes begin: assets, number of rooms, and seed."""
        return tuple(f"Home-{self.assets}-{self.rooms[k % len(self.rooms)]}-{self.seed}.{k}" for k in range(self.count))


class SecondTour(Section):
    """The tour of the second visit, if it differs from the first."""

    other_waypoints: bool = Field(description="whether its waypoints are sampled from another cell than the first's")
    first_yaw_deg: Annotated[float, Field(ge=0, lt=360)] = Field(description="degrees, yaw of its first view")


Range = Annotated[tuple[float, ...], Field(min_length=2, max_length=2)]


class Lighting(Section):
    """The light of the second visit: uniform draws from ranges, as in AI2-THOR's RandomizeLighting."""

    brightness: Range = Field(description="least and greatest factor of every light, above 0")
    hue: Range = Field(description="of the tint of the lights, in [0, 1]")
    saturation: Range = Field(description="of the tint of the lights, in [0, 1]")
    materials: bool = Field(False, description="whether the second visit has other materials, too (RandomizeMaterials)")

    @property
    def ranges(self) -> Mapping[str, tuple[float, float]]:
        """What is drawn of the light, by name."""
        return {name: (ends[0], ends[1]) for name in ("brightness", "hue", "saturation") for ends in (getattr(self, name),)}

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        for name, (low, high) in self.ranges.items():
            if low > high:
                raise ValueError(f"{name} is {[low, high]}; write the least before the greatest")
            if name == "brightness" and low <= 0:
                raise ValueError(f"{name} begins with {low}; a light has more than 0")
            if name != "brightness" and not 0 <= low <= high <= 1:
                raise ValueError(f"{name} is {[low, high]}; it lies between 0 and 1")
        return self


def _name(value: str) -> str:
    if value in TAKEN or not re.fullmatch(NAME, value):
        says = f"write small letters, with _ between words, and not {' or '.join(sorted(TAKEN))}"
        raise ValueError(f"{value!r} cannot name a split; {says}")
    return value


class Rules(Section):
    """Rules of a split's runs that the paper's protocol does not have. They stand in its candidates and episodes."""

    exclusive: bool = Field(False, description="whether a success must be nearer to the answer than to any rival")
    grid: Literal["first", "second"] = Field("second", description="visit whose grid of reachable positions agents get")
    same_walk: bool = Field(False, description="whether movers walk alike in the runs of all arms on an episode under a seed")


class Split(Section):
    """A split. By default it follows the paper: one change, the same tour twice."""

    name: Annotated[str, AfterValidator(_name)] = Field(description="the key of its entry, in file names and ids")
    in_main_job: bool = Field(True, description="whether results/all has its tables; results/splits/NAME has those of any split")
    scenes: Annotated[tuple[Scene, ...], Distinct] = Field((), description="floor plans and houses; by default main's")
    homes: Homes | None = Field(None, description="homes that are drawn for the split, in place of scenes")
    changes: Annotated[tuple[Annotated[Whole, Field(ge=1, le=3)], ...], Distinct] = Field(
        (1,), min_length=1, description="numbers of instances of the queried category that change, each under another relation"
    )
    crossed: Crossed | None = Field(None, description="several things change, all queries are asked; null for one query")
    second_tour: SecondTour | None = Field(None, description="the tour of the second visit; null for the first's again")
    off_grid: bool = Field(False, description="whether tours have poses off the grid and off quarters of a turn")
    light: Lighting | None = Field(None, description="another light in the second visit; null for the scene's own")
    sensors: Level | None = Field(None, description="level of section sensors; null for exact depth and poses")
    rules: Rules = Field(Rules(), description="rules of runs that the paper does not have")
    episodes: PerRelation = Field(NONE, description="episodes released per relation; a crossed split releases all")
    draws: PerRelation = Field(NONE, description="candidates per relation and scene; a crossed split draws one world pair")
    tries: Some | None = Field(None, description="attempts per draw; null counts refused candidates as drawn")
    arms: Annotated[tuple[str, ...], Distinct] = Field(
        description="arms that answer its queries; on main those `on_main` if not given"
    )

    @model_validator(mode="after")
    def _has_scenes(self) -> Self:
        if (self.homes is None) != bool(self.scenes):
            raise ValueError("a split has either scenes or homes; write one of them")
        return self

    @model_validator(mode="after")
    def _of_one_kind(self) -> Self:
        if 1 in self.changes and self.changes != (1,):
            raise ValueError("changes: one change and several are drawn in different ways; write [1], or numbers above 1")
        if self.crossed is not None and not (self.changes == (1,) and self.episodes == NONE and self.draws == NONE):
            raise ValueError("a crossed split draws one world pair per scene; take changes, episodes and draws out")
        if self.crossed is None and NONE in (self.episodes, self.draws):
            raise ValueError("a split without crossed needs episodes and draws; give them")
        return self

    @property
    def stream(self) -> tuple[str, ...]:
        """The name of the split in random streams and ids. Split main has none there."""
        return () if self.name == MAIN else (self.name,)

    @property
    def places(self) -> tuple[str, ...]:
        """Names of its scenes; of homes, how the names begin, since only drawing completes them."""
        return self.scenes if self.homes is None else self.homes.stems

    @property
    def plain(self) -> bool:
        """Whether it differs from the paper's protocol in the scripted changes alone: its tours are like the main split's."""
        return self.crossed is None and self.second_tour is None

    @property
    def single(self) -> bool:
        """Whether one instance changes in a pair of tours, which then serves one query."""
        return self.changes == (1,) and self.crossed is None


Splits = Annotated[dict[str, Split], Named]
"""By name."""


def complete_splits(tree: Any) -> Any:
    """Return all sections with complete splits: those without scenes have the scenes of main, and arms `on_main` answer main."""
    if not isinstance(tree, Mapping) or not isinstance(splits := tree.get("splits"), Mapping):
        return tree
    arms, main = tree.get("arms"), splits.get(MAIN)
    if main is None:
        raise ValueError(f"splits has no {MAIN}; add it")
    if not isinstance(main, Mapping):
        return tree
    complete = {
        name: entry if isinstance(entry, Mapping) and entry.get("homes") else _with(entry, "scenes", main.get("scenes"))
        for name, entry in splits.items()
    }
    entries = arms.items() if isinstance(arms, Mapping) else ()
    names = [name for name, arm in entries if isinstance(arm, Mapping) and arm.get("on_main", True)]
    complete[MAIN] = _with(complete[MAIN], "arms", names)
    return {**tree, "splits": complete}


def _with(entry: Any, name: str, value: Any) -> Any:
    lacks = isinstance(entry, Mapping) and entry.get(name) is None and value is not None
    return {**entry, name: value} if lacks else entry
