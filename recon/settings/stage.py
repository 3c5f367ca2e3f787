"""Tables of settings: frozen, validated at construction, aware of the values given."""

from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import wraps
from typing import Annotated, Any, TypeVar, dataclass_transform, get_args

from pydantic import ConfigDict, Field, ValidationError
from pydantic.dataclasses import dataclass as checked_dataclass

from recon.errors import InputError

STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)

Positive = Annotated[float, Field(gt=0)]
NonNegative = Annotated[float, Field(ge=0)]
Share = Annotated[float, Field(ge=0, le=1)]
Count = Annotated[int, Field(ge=1)]

Table = TypeVar("Table")

_KEYS = {
    "missing": "missing",
    "extra_forbidden": "unknown",
    "unexpected_keyword_argument": "unknown",
}
# What a value has to be, by the type of pydantic's error.
_NEEDS = {
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "dataclass_type": "a {class_name} or its values by name",
    "finite_number": "a finite number",
    "float_parsing": "a number",
    "float_type": "a number",
    "greater_than": "a number > {gt:g}",
    "greater_than_equal": "a number >= {ge:g}",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "less_than": "a number < {lt:g}",
    "less_than_equal": "a number <= {le:g}",
    "multiple_of": "a multiple of {multiple_of}",
    "literal_error": "{expected}",
    "string_type": "text in quotes",
    "too_long": "a list of at most {max_length}",
    "too_short": "a list of at least {min_length}",
    "tuple_type": "a list, such as [1, 2],",
}


@dataclass_transform(
    frozen_default=True, kw_only_default=True, field_specifiers=(Field, field, dataclass)
)
def table(cls: type[Table]) -> type[Table]:
    """Make a class a table of settings: a frozen dataclass that rejects invalid values.

    Its instances raise `InputError`, and remember which values were given (see `given`): others
    may follow from a recording or a world.
    """
    made: Any = checked_dataclass(frozen=True, kw_only=True, config=STRICT)(cls)
    made.__init__ = _remembering(made.__init__, made)
    return made  # type: ignore[no-any-return]


def given(instance: Any) -> dict[str, Any]:
    """The explicitly given values of a table, by name."""
    names = instance.__dict__.get("_given", {field.name for field in fields(instance)})
    return {name: getattr(instance, name) for name in instance.__dict__ if name in names}


def _remembering(init: Callable[..., None], cls: Any) -> Callable[..., None]:
    # Pydantic would read true as 1, but not the word.
    numbers = {name for name, one in cls.__pydantic_fields__.items() if _is_number(one.annotation)}

    @wraps(init)
    def __init__(self: Any, **values: Any) -> None:
        words = {name: str(values[name]) for name in numbers if isinstance(values.get(name), bool)}
        try:
            init(self, **values | words)
        except ValidationError as error:
            raise InputError(first_fault(error, cls.__name__)) from error
        object.__setattr__(self, "_given", frozenset(values))

    return __init__


def _is_number(annotation: Any) -> bool:
    """True of an integer, a float, and of either or None."""
    parts = (getattr(part, "__origin__", part) for part in get_args(annotation))
    return bool({int, float} & {annotation, *parts})


def first_fault(error: ValidationError, table_name: str = "") -> str:
    """The first error, in one line: name, value, requirement."""
    first = error.errors()[0]
    # A step such as "tuple[float, float]" is one of several types.
    steps = [str(step) for step in (table_name, *first["loc"]) if "[" not in str(step)]
    name = ".".join(filter(None, steps))
    # The error of a whole table states its own values; that of a missing key has none.
    has_value = first["loc"] and not isinstance(first["input"], dict)
    if first["type"] in _KEYS:
        return f"{name} is {_KEYS[first['type']]}"
    value = f" is {first['input']!r}" if has_value else ""
    need = _NEEDS.get(first["type"])
    if need is None or not has_value:
        return f"{name}{value}: {first['msg'].removeprefix('Value error, ')}"
    return f"{name}{value}, but {need.format(**first.get('ctx', {}))} is needed"
