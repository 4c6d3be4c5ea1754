"""The paper's own figures (paper.yaml), checked, by key."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Annotated

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

PAPER = Path(__file__).with_name("paper.yaml")


class Figure(BaseModel):
    """A figure of the text: a value, an upper bound of a p value, or a range; and the place it is printed at."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    value: float | None = None
    below: Annotated[float, Field(gt=0, le=1)] | None = None
    low: float | None = None
    high: float | None = None
    place: Annotated[str, Field(min_length=1)]

    @model_validator(mode="after")
    def _one_kind(self) -> Figure:
        kinds = (self.value is not None, self.below is not None, self.low is not None and self.high is not None)
        if sum(kinds) != 1 or (self.low is None) != (self.high is None):
            raise ValueError("a figure is a value, an upper bound (below) or a range (low and high)")
        if self.low is not None and self.high is not None and self.low > self.high:
            raise ValueError(f"a range goes from low to high, not from {self.low} to {self.high}")
        return self


class _Rows(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    place: str
    titles: dict[str, str] = {}
    rows: dict[str, dict[str, float]]


class _File(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    tables: dict[str, _Rows]
    text: dict[str, Figure]
    later: dict[str, str]


@cache
def _parsed(text: str) -> _File:
    return _File.model_validate(yaml.safe_load(text))


class Paper(Mapping[str, Figure]):
    """Every figure by its key: "static.two.all" of a table, "parser_accuracy" of the text.

    titles: of rows of the tables, by "static.two". later: beginnings of keys that nothing is compared with yet, and what they
    wait for.
    """

    def __init__(self, figures: Mapping[str, Figure], later: Mapping[str, str], titles: Mapping[str, str]) -> None:
        self._figures = dict(figures)
        self.titles = dict(titles)
        self.later = dict(later)

    @classmethod
    def read(cls, path: Path = PAPER) -> Paper:
        """Raises ValueError in one line that names the file and the key."""
        try:
            content = _parsed(path.read_text(encoding="utf-8"))
        except yaml.YAMLError as error:
            raise ValueError(f"{path}: {' '.join(str(error).split())}") from None
        except ValidationError as error:
            first = error.errors()[0]
            raise ValueError(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from None
        figures = {
            f"{name}.{row}.{column}": Figure(value=value, place=table.place)
            for name, table in content.tables.items()
            for row, cells in table.rows.items()
            for column, value in cells.items()
        }
        titles = {f"{name}.{row}": title for name, table in content.tables.items() for row, title in table.titles.items()}
        return cls(figures | content.text, content.later, titles)

    def __getitem__(self, key: str) -> Figure:
        return self._figures[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._figures)

    def __len__(self) -> int:
        return len(self._figures)

    def for_later(self, key: str) -> bool:
        """Whether a figure is declared as waiting for metrics that do not exist."""
        return key.startswith(tuple(self.later))
