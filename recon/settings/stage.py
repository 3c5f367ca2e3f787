"""Tables of settings: frozen, validated at construction, aware of the values given."""

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import wraps
from typing import Annotated, Any, TypeVar, dataclass_transform

from pydantic import ConfigDict, Field, ValidationError
from pydantic.dataclasses import dataclass as checked_dataclass

from recon.errors import InputError

STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)

Positive = Annotated[float, Field(gt=0)]
NonNegative = Annotated[float, Field(ge=0)]
Share = Annotated[float, Field(ge=0, le=1)]
Count = Annotated[int, Field(ge=1)]

Table = TypeVar("Table")


@dataclass_transform(
    frozen_default=True, kw_only_default=True, field_specifiers=(Field, field, dataclass)
)
def table(cls: type[Table]) -> type[Table]:
    """Make a class a table of settings: a frozen dataclass that rejects invalid values.

    Its instances raise `InputError`, and remember which values were given (see `given`): others
    may follow from a recording or a world.
    """
    made: Any = checked_dataclass(frozen=True, kw_only=True, config=STRICT)(cls)
    made.__init__ = _remembering(made.__init__, made.__name__)
    return made  # type: ignore[no-any-return]


def given(instance: Any) -> dict[str, Any]:
    """The explicitly given values of a table, by name."""
    names = instance.__dict__.get("_given", {field.name for field in fields(instance)})
    return {name: getattr(instance, name) for name in instance.__dict__ if name in names}


def _remembering(init: Callable[..., None], name: str) -> Callable[..., None]:
    @wraps(init)
    def __init__(self: Any, **values: Any) -> None:
        try:
            init(self, **values)
        except ValidationError as error:
            raise InputError(first_fault(error, name)) from error
        object.__setattr__(self, "_given", frozenset(values))

    return __init__


def first_fault(error: ValidationError, table_name: str = "") -> str:
    """The first error, in one line: name, value, requirement."""
    first = error.errors()[0]
    name = ".".join(str(step) for step in (table_name, *first["loc"]) if step != "")
    message = first["msg"].removeprefix("Value error, ")
    # The error of a whole table states its own values; that of a missing key has none.
    has_value = first["loc"] and not isinstance(first["input"], dict)
    value = f" is {first['input']!r}" if has_value else ""
    return f"{name}{value}: {message}"
