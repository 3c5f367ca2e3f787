"""The reference of settings: type, default, meaning and the thesis's value of each."""

import ast
import inspect
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from recon.settings.presets import with_preset
from recon.settings.settings import Settings


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """One value that can be set."""

    name: str
    """As `--set` takes it: "stage.name"."""
    type: str
    """In words, with its choices or bounds: "float > 0"."""
    default: Any
    thesis: Any
    """Value of the preset `thesis`."""
    meaning: str
    """Its documentation, with the unit."""

    def as_json(self) -> dict[str, Any]:
        """The setting as `recon settings --json` prints it."""
        return asdict(self)


def reference() -> Iterator[Setting]:
    """Every setting, in the order of the stages."""
    default, thesis = asdict(Settings()), asdict(with_preset(Settings(), "thesis"))
    for stage, cls in get_type_hints(Settings).items():
        meanings = _meanings(cls)
        for name, field in cls.__pydantic_fields__.items():
            yield Setting(
                name=f"{stage}.{name}",
                type=_words(field.annotation, field.metadata),
                default=default[stage][name],
                thesis=thesis[stage][name],
                meaning=meanings.get(name, ""),
            )


def _meanings(cls: type) -> dict[str, str]:
    """The documentation of each field of a class, read from its source."""
    body = ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0]
    assert isinstance(body, ast.ClassDef)
    return {
        field.target.id: " ".join(str(text.value.value).split())
        for field, text in pairwise(body.body)
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)
        if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant)
    }


def _words(annotation: Any, constraints: Sequence[Any] = ()) -> str:
    """A type in a readable form: the choices of a `Literal`, a number with its bounds."""
    kind, parts = get_origin(annotation), get_args(annotation)
    if kind is Annotated:
        return _words(parts[0], parts[1].metadata)
    if kind is Literal:
        return " | ".join(parts)
    if kind in (Union, UnionType):
        return " | ".join(_words(part) for part in parts)
    if kind is tuple:
        return ", ".join("..." if part is ... else _words(part) for part in parts)
    name = "none" if annotation is NoneType else annotation.__name__
    return f"{name} {' and '.join(_bounds(constraints))}".rstrip()


def _bounds(constraints: Sequence[Any]) -> Iterator[str]:
    """The bounds of a number, as "> 0"."""
    for constraint in constraints:
        for name, sign in {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}.items():
            if hasattr(constraint, name):
                yield f"{sign} {getattr(constraint, name):g}"
