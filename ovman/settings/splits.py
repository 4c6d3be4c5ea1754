"""Section `splits`: what each split releases, and in what it differs from the paper's protocol."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from ovman.section import Count, Distinct, Named, Section, Some, Whole
from ovman.settings.benchmark import Level, PerRelation, Scene

MAIN = "main"
"""The split that is always there. Random streams, ids and files of metrics do not have its name."""
NAME = r"[a-z]+(_[a-z]+)*"
"""Names of splits."""
TAKEN = frozenset({"static", "embodied"})
"""Names that files of metrics have already."""


class Others(Section):
    """Instances of other categories that change, too, and that no query is about."""

    count: tuple[Some, ...] = Field(min_length=2, max_length=2, description="fewest and most of them in a pair of tours")
    alike: PerRelation = Field(description="least number of them that change like the scripted instance; STABLE: like the mover")
    size_ratio: Annotated[float, Field(ge=1)] = Field(description="largest ratio of the volumes of boxes, either way")

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        fewest, most = self.count
        if fewest > most:
            raise ValueError(f"count is {list(self.count)}; write the fewest before the most")
        for relation, alike in self.alike:
            if alike > fewest:
                raise ValueError(f"alike.{relation} is {alike}, but count begins with {fewest}; raise that or lower alike")
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


class Split(Section):
    """A split. By default it follows the paper: one change, the same tour twice."""

    name: Annotated[str, AfterValidator(_name)] = Field(description="the key of its entry, in file names and ids")
    in_main_job: bool = Field(True, description="whether results/all has its tables; results/splits/NAME has those of any split")
    scenes: Annotated[tuple[Scene, ...], Distinct] = Field((), description="floor plans and houses; by default main's")
    homes: Homes | None = Field(None, description="homes that are drawn for the split, in place of scenes")
    changes: Annotated[tuple[Annotated[Whole, Field(ge=1, le=3)], ...], Distinct] = Field(
        (1,), min_length=1, description="numbers of instances of the queried category that change, each under another relation"
    )
    others: Others | None = Field(None, description="instances of other categories that change as well; null for none")
    second_tour: SecondTour | None = Field(None, description="the tour of the second visit; null for the first's again")
    light: Lighting | None = Field(None, description="another light in the second visit; null for the scene's own")
    sensors: Level | None = Field(None, description="level of section sensors; null for exact depth and poses")
    episodes: PerRelation = Field(description="episodes released per relation")
    instances_in_turn: bool = Field(False, description="whether each certified instance is asked about before one again")
    sizes_in_turn: bool = Field(False, description="whether the scripted change is as often the largest as chance has it")
    draws: PerRelation = Field(description="candidates per relation and scene")
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
        if 1 in self.changes and not self.single:
            raise ValueError("changes: one change and several are drawn in different ways; write [1], or numbers above 1")
        if self.others is not None and not self.single:
            raise ValueError(f"others change beside one scripted change, but changes is {list(self.changes)}; write [1] there")
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
        return self.others is None and self.second_tour is None

    @property
    def single(self) -> bool:
        """Whether one instance of the queried category changes in a pair of tours, which then serves one query."""
        return self.changes == (1,)


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
