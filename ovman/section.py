"""What every section of the settings has in common, and kinds of values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Self, cast, get_args, get_origin

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, PrivateAttr, model_validator


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _named(value: Any) -> Any:
    if not isinstance(value, Mapping):
        return value
    for name, entry in value.items():
        if isinstance(entry, Mapping) and entry.get("name", name) != name:
            raise ValueError(f"{name}.name is not a setting; the key is the name")
    entries = {name: entry for name, entry in value.items() if entry is not None}
    return {name: {**entry, "name": name} if isinstance(entry, Mapping) else entry for name, entry in entries.items()}


def _distinct(values: tuple[Any, ...]) -> tuple[Any, ...]:
    for number, value in enumerate(values):
        if value in values[:number]:
            raise ValueError(f"{value} is there twice")
    return values


Whole = Annotated[int, BeforeValidator(_whole)]
"""An integer, which a file may write as 2.0."""
Count = Annotated[Whole, Field(ge=0)]
Some = Annotated[Whole, Field(ge=1)]
Metres = Annotated[float, Field(gt=0)]
Voxels = Annotated[float, Field(gt=0)]
Spread = Annotated[float, Field(ge=0)]
Angle = Annotated[float, Field(gt=0, le=180)]
Probability = Annotated[float, Field(ge=0, lt=1)]
Fraction = Annotated[float, Field(gt=0, le=1)]
Named = BeforeValidator(_named)
"""A mapping whose entries take their name from their key; an entry that is null is left out."""
Distinct = AfterValidator(_distinct)
"""A list without a value that is there twice."""
Word = Field(strict=False)
"""A member of an enumeration, which a file writes as text."""


class Section(BaseModel):
    """A section of the settings: frozen, strict about types, without unknown keys. A tuple is a list in files.

    A job of the workflow has partial sections, which hold only the constants that its rule gives (`partial`). Reading another
    constant raises AttributeError.
    """

    # Built at the first validation: a job, whose constants are valid already, starts sooner.
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, defer_build=True)
    _holder: str = PrivateAttr("")
    _path: str = PrivateAttr("")

    @model_validator(mode="before")
    @classmethod
    def _tuples(cls, value: Any) -> Any:
        if not isinstance(value, Mapping):
            return value
        return {name: tuple(one) if isinstance(one, list) else one for name, one in value.items()}

    if not TYPE_CHECKING:  # with it mypy would take every name for a field

        def __getattr__(self, name: str) -> Any:
            if name in type(self).model_fields:
                says = f"was not given {_join(self._path, name)!r}; name it in the params of its rule"
                raise AttributeError(f"settings: {self._holder} {says}")
            return super().__getattr__(name)

    @classmethod
    def partial(cls, values: Mapping[str, Any], holder: str = "this job", path: str = "") -> Self:
        """Build a section that holds only these values, which come from validated settings and are not validated again.

        values: of fields by name, sections as mappings, sequences as tuples or lists. holder: whom the settings are for, and
        path: the dotted name of the section, both for messages. AttributeError for a name that the section does not have.
        """
        for name in values:
            if name not in cls.model_fields:
                raise AttributeError(f"settings: {_join(path, name)!r} is not a constant")
        fields: dict[str, Any] = {}
        for name, field in cls.model_fields.items():  # in the order of the models, as in records
            kind: Any = field.annotation
            inner = _join(path, name)
            if name in values:
                fields[name] = _restored(kind, values[name], holder, inner)
            elif _is_section(kind):  # there without a value, so that the error names the constant
                fields[name] = kind.partial({}, holder, inner)
        made: Any = cls.model_construct()
        made.__dict__ = fields
        made._holder, made._path = holder, path
        return cast(Self, made)


def plain(value: Any) -> Any:
    """Return a value with sections as mappings, in their order."""
    if isinstance(value, Section | Mapping):
        return {name: plain(one) for name, one in dict(value).items()}
    return value


def _restored(kind: Any, value: Any, holder: str, path: str) -> Any:
    """Return a value of a field as validation would: the inverse of `plain`."""
    if not isinstance(value, Mapping):
        return tuple(value) if isinstance(value, list) else value
    if get_origin(kind) is dict:
        return {name: _entry(get_args(kind)[1], one, holder, _join(path, name)) for name, one in value.items()}
    section: Any = next(one for one in (kind, *get_args(kind)) if _is_section(one))
    return section.partial(value, holder, path)


def _entry(kind: Any, value: Any, holder: str, path: str) -> Any:
    if not _is_section(kind) or not isinstance(value, Mapping):
        return value
    whole = value.keys() == kind.model_fields.keys()  # an arm, whose words become members of enumerations
    return kind.model_validate(dict(value)) if whole else kind.partial(value, holder, path)


def _is_section(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, Section)


def _join(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name
