"""Kinds of values, and what every section has in common."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Self, cast, get_args, get_origin

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PrivateAttr


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _sequence(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


Whole = Annotated[int, BeforeValidator(_whole)]
"""2.0 is 2."""
Count = Annotated[Whole, Field(ge=0)]
Some = Annotated[Whole, Field(ge=1)]
Metres = Annotated[float, Field(gt=0)]
Voxels = Annotated[float, Field(gt=0)]
Probability = Annotated[float, Field(ge=0, lt=1)]
Fraction = Annotated[float, Field(gt=0, le=1)]
Listed = BeforeValidator(_sequence)
"""A list in YAML is a tuple here."""


def listed(value: Any) -> Any:
    """A mapping of a setting as JSON that keeps its order: a list of its entries, which have their names, or of its items."""
    if not isinstance(value, dict):
        return value
    known = _listed.get(id(value))
    if known is None or known[0] is not value:
        if len(_listed) == KNOWN:
            _listed.clear()
        entries = [_plain(entry) if isinstance(entry, Section) else [name, entry] for name, entry in value.items()]
        known = _listed[id(value)] = value, entries
    return known[1]


KNOWN = 64
_listed: dict[int, tuple[dict[str, Any], list[Any]]] = {}
"""Mappings of frozen settings that were listed, by their identity: a workflow asks for the same ones some hundred times."""


def _plain(value: Any) -> Any:
    """A section as a mapping, and sections in it."""
    return {name: _plain(one) for name, one in value} if isinstance(value, Section) else value


def _by_name(entries: list[Any], kind: Any, stage: str, path: str) -> dict[str, Any]:
    """The inverse of `listed`. kind: of the mapping's values; stage, path: as for `Section.owned`."""
    if not (isinstance(kind, type) and issubclass(kind, Section)):
        return dict(entries)
    whole = kind.model_fields.keys()
    return {
        entry["name"]: kind.model_validate(entry)
        if whole == entry.keys()
        else kind.owned(entry, stage, f"{path}.{entry['name']}")
        for entry in entries
    }


def _section_in(kind: Any) -> type[Section] | None:
    """The section that a field of this annotation may have instead of null, None for fields of other values."""
    return next((one for one in get_args(kind) if isinstance(one, type) and issubclass(one, Section)), None)


class Section(BaseModel):
    """A section of config.yaml: frozen, with no key beside its fields, and no value of one type taken for another.

    A job of the workflow has sections that hold only what its stage owns (`ovman.workflow.parameter`). Reading another field
    raises AttributeError with the stage and the constant in one line.
    """

    # Built at the first validation: a job, whose constants are valid already, starts sooner.
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, defer_build=True)
    _stage: str = PrivateAttr("")
    _path: str = PrivateAttr("")

    if not TYPE_CHECKING:  # with it mypy would take every name for a field

        def __getattr__(self, name: str) -> Any:
            if name in type(self).model_fields:
                where = f"{self._path}.{name}" if self._path else name
                owners = "STAGES in ovman/workflow/stages.py lists the owners"
                raise AttributeError(f"stage {self._stage!r} does not own the constant {where!r}; {owners}")
            return super().__getattr__(name)

    @classmethod
    def owned(cls, values: Mapping[str, Any], stage: str, path: str = "") -> Self:
        """The section as a stage owns it: fields that are not in `values` raise when they are read.

        values: fields of this section, sections as mappings. They come from validated settings and are not validated again.
        """
        fields: dict[str, Any] = {}
        for name, value in values.items():
            kind, inner = cls.model_fields[name].annotation, f"{path}.{name}" if path else name
            if isinstance(kind, type) and issubclass(kind, Section):
                fields[name] = kind.owned(value, stage, inner)
            elif get_origin(kind) is dict:
                fields[name] = _by_name(value, get_args(kind)[1], stage, inner)
            elif isinstance(value, Mapping) and (section := _section_in(kind)):
                fields[name] = section.model_validate(value)
            else:
                fields[name] = tuple(value) if isinstance(value, list) else value
        # A section of which the stage owns nothing is there, so that the error names the constant.
        for name, field in cls.model_fields.items():
            kind = field.annotation
            if name not in fields and isinstance(kind, type) and issubclass(kind, Section):
                fields[name] = kind.owned({}, stage, f"{path}.{name}" if path else name)
        fields = {name: fields[name] for name in cls.model_fields if name in fields}  # the order of config.yaml, as in records
        made = cast(Self, cls.model_construct(**fields))
        made.__dict__ = fields
        made._stage, made._path = stage, path
        return made
