"""The catalogue: names as rules over parts, shapes and ratios of size, in TOML."""

import itertools
import tomllib
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass

from recon.errors import InputError
from recon.settings.stage import STRICT, NonNegative

SHIPPED = Path(__file__).with_name("catalogue.toml")

UprightShape = Literal["cylinder", "sphere", "ellipsoid", "cone"]
FITTED = {"cone": "truncated cone"}
"""A cone is fitted with a free top: no map shows its tip."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PartRule:
    """One part of a kind of object."""

    role: str
    shapes: Annotated[tuple[UprightShape, ...], Field(min_length=1)]
    """Any of these."""
    slenderness: tuple[NonNegative, NonNegative] | None = None
    """Bounds of its height over its radius; of a cone, over what its radius falls by."""


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Kind:
    """One name, and what a thing must be to get it."""

    name: Annotated[str, Field(min_length=1)]
    parts: Annotated[tuple[PartRule, ...], Field(min_length=1, max_length=3)]
    """From the ground up."""
    ratio: tuple[NonNegative, NonNegative] | None = None
    """Bounds of the lowest part's largest radius over that of the part on it."""

    @property
    def stacks(self) -> list[tuple[str, ...]]:
        """Every combination of fitted shapes that the parts allow; a cone may be truncated."""
        fitted = ({FITTED.get(shape, shape): None for shape in part.shapes} for part in self.parts)
        return list(itertools.product(*fitted))


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Catalogue:
    """All names."""

    object: Annotated[tuple[Kind, ...], Field(min_length=1)]


def read_catalogue(path: Path | None = None) -> tuple[Kind, ...]:
    """The kinds of a catalogue file, by default the shipped one.

    Raises
    ------
    InputError
        Naming the file and its first fault.
    """
    source = SHIPPED if path is None else path
    try:
        with source.open("rb") as file:
            return TypeAdapter(Catalogue).validate_python(tomllib.load(file)).object
    except OSError as error:
        raise InputError(f"{source}: {error.strerror}, but a catalogue is needed") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{source} is no TOML: {error}") from error
    except ValidationError as error:
        fault = error.errors()[0]
        place = ".".join(map(str, fault["loc"]))
        raise InputError(f"{source}: {place}: {fault['msg']}") from error
