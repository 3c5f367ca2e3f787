"""The reference of settings: every value with its type, default, meaning and the thesis's value."""

import ast
import inspect
import textwrap
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from typing import Any, get_type_hints

from recon.settings.presets import with_preset
from recon.settings.settings import Settings


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """One value that can be set."""

    name: str
    """As `--set` takes it: "stage.name"."""
    type: str
    """As its definition writes it."""
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
        documented = _documented(cls)
        for field in fields(cls):
            type_, meaning = documented[field.name]
            yield Setting(
                name=f"{stage}.{field.name}",
                type=type_,
                default=default[stage][field.name],
                thesis=thesis[stage][field.name],
                meaning=meaning,
            )


def _documented(cls: type) -> dict[str, tuple[str, str]]:
    """Type and documentation of the fields of a class, read from its source."""
    body = ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0]
    assert isinstance(body, ast.ClassDef)
    found: dict[str, tuple[str, str]] = {}
    name = ""
    for node in body.body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            name = node.target.id
            found[name] = (_plain_type(node.annotation), "")
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and name:
            found[name] = (found[name][0], " ".join(str(node.value.value).split()))
        else:
            name = ""
    return found


def _plain_type(annotation: ast.expr) -> str:
    """An annotation as people read it: the choices of a `Literal`, else its source."""
    if isinstance(annotation, ast.Subscript) and ast.unparse(annotation.value) == "Literal":
        return ast.unparse(annotation.slice).strip("()").replace("'", "").replace(", ", " | ")
    return ast.unparse(annotation)
