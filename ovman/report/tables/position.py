"""The paper's Table "position": the benchmark against the closest prior work, from a file (position.yaml) with its source."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import pandas as pd
import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ovman.report.tables.columns import words
from ovman.report.tables.table import Table

POSITION = Path(__file__).with_name("position.yaml")


class Has(StrEnum):
    """Whether a work has a property."""

    YES = "yes"
    PARTLY = "partly"
    NO = "no"


class Work(BaseModel):
    """One row, or two works that agree in all. remark: beside the last property."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    work: Annotated[str, Field(min_length=1)]
    both_visits: Has
    open_vocabulary: Has
    change_relation: Has
    empty_past: Has
    remark: str | None = None


class Position(BaseModel):
    """The rows in the order of the paper. source: where they are printed."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    source: Annotated[str, Field(min_length=1)]
    rows: tuple[Work, ...]


def read(path: Path = POSITION) -> Position:
    """Raises ValueError in one line that names the file and the key."""
    try:
        return Position.model_validate(yaml.safe_load(path.read_text(encoding="utf-8")))
    except yaml.YAMLError as error:
        raise ValueError(f"{path}: {' '.join(str(error).split())}") from None
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from None


def position_table(path: Path = POSITION) -> Table:
    """A row a work, a column a property."""
    position = read(path)
    rows = pd.DataFrame(
        [
            one.model_dump(exclude={"remark"})
            | {"empty_past": f"{one.empty_past} ({one.remark})" if one.remark else one.empty_past}
            for one in position.rows
        ]
    )
    columns = (
        words("work"),
        words("both_visits", "two visits"),
        words("open_vocabulary", "open vocabulary"),
        words("change_relation", "goal by change relation"),
        words("empty_past", "empty past locations"),
    )
    caption = "The benchmark against the closest prior work. No single column is new; no other row has all four. "
    caption += f"Source: {position.source}."
    return Table(caption, columns, rows.map(str))
