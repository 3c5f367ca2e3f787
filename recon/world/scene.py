"""The geometry file, read and written (thesis Appendix B, and MESH as an extension).

Lines that begin with ``#`` are comments with free text; the order of the other lines matters, each
of which holds one value. A comment that names another value of the record than the expected one
shows that the expected one is missing.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from recon.errors import InputError
from recon.files import may_read
from recon.world.fields import (
    SHADER_FIELDS,
    STRUCTURE,
    VERTEX,
    VISUAL_FIELDS,
    Field,
    Kind,
    Name,
    whole,
)
from recon.world.textures import SHIPPED, find_texture
from recon.world.visuals import (
    NONE,
    MeshVisual,
    PolygonVisual,
    Scene,
    Shader,
    Vertex,
    Visual,
)

MAX_QUOTED = 60

KINDS: dict[str, type[Visual]] = {record.kind: record for record in VISUAL_FIELDS}


class _Line(NamedTuple):
    number: int
    comment: str
    """Text of the last comment since the previous value, lower case."""
    text: str


class _Reader:
    """The value lines of a file, read one after the other."""

    def __init__(self, path: Path) -> None:
        self.path = path
        # Comments may be in any encoding.
        rows = path.read_text(encoding="utf-8-sig", errors="replace").rstrip().split("\n")
        self.lines = list(_value_lines(rows))
        self.num_rows = len(rows)
        self.next = 0

    def take(self, what: str, comment: str, kind: Kind, others: frozenset[str] = STRUCTURE) -> Any:
        """The next value, named `what` in messages; `others` are comments of other values."""
        if self.next == len(self.lines):
            self.fail(self.num_rows, f"the file ends before {what}, but {kind.need} is needed")
        line = self.lines[self.next]
        if line.comment in others and line.comment != comment.lower():
            self.fail(
                line.number,
                f"{what} is missing: the value is one of {line.comment!r}, "
                f"but {kind.need} is needed",
            )
        try:
            value = kind.parse(line.text)
        except (ValueError, OverflowError):
            self.fail(line.number, f"{what} is {_shown(line.text)}, but {kind.need} is needed")
        self.next += 1
        return value

    def fail(self, number: int, message: str) -> NoReturn:
        raise InputError(f"{self.path}:{number}: {message}")

    def fail_last(self, message: str) -> NoReturn:
        """Fail at the last value read."""
        self.fail(self.lines[self.next - 1].number, message)


def _shown(text: str) -> str:
    """A line as quoted in messages, shortened: other files may have very long lines."""
    return repr(text if len(text) <= MAX_QUOTED else f"{text[:MAX_QUOTED]}...")


def _value_lines(rows: list[str]) -> Iterator[_Line]:
    comment = ""
    for number, row in enumerate(rows, start=1):
        text = row.strip()
        if text.startswith("#"):
            comment = text[1:].strip().lower()
        elif text:
            yield _Line(number, comment, text)
            comment = ""


def read_scene(path: str | Path) -> Scene:
    """Read a geometry file.

    Raises
    ------
    InputError
        "FILE:LINE: what, value, need": for a missing or unreadable value, a number out of range,
        wrong counts, an unknown visual, and a missing texture or mesh of a visual. Textures that no
        visual uses are not looked up.
    """
    reader = _Reader(Path(path))
    count = {
        name: reader.take(f"{name} count", f"{name} count", whole(0))
        for name in ("shader", "texture", "visual")
    }
    shaders = tuple(_shader(reader, n) for n in range(count["shader"]))
    textures = tuple(_texture(reader, n) for n in range(count["texture"]))
    visuals = tuple(_visual(reader, n, len(shaders), textures) for n in range(count["visual"]))
    if reader.next < len(reader.lines):
        line = reader.lines[reader.next]
        reader.fail(
            line.number,
            f"visual count is {len(visuals)}, but {_shown(line.text)} follows the last one",
        )
    return Scene(
        shaders=shaders, textures=textures, visuals=visuals, folder=reader.path.absolute().parent
    )


def _shader(reader: _Reader, number: int) -> Shader:
    return Shader(**_values(reader, f"shader {number}", SHADER_FIELDS))


def _texture(reader: _Reader, number: int) -> str:
    name: str = reader.take(f"texture {number}", "", Name("the name of an image"))
    if name in KINDS:
        reader.fail_last(f"texture {number} is {name!r}, but the name of an image is needed")
    return name


def _visual(reader: _Reader, number: int, num_shaders: int, textures: tuple[str, ...]) -> Visual:
    kind = reader.take(f"visual {number} type", "Visual type", Name(f"one of {', '.join(KINDS)}"))
    if kind not in KINDS:
        reader.fail_last(
            f"visual {number} type is {_shown(kind)}, but one of {', '.join(KINDS)} is needed"
        )
    record, what = KINDS[kind], f"visual {number} ({kind})"
    values = _values(reader, what, VISUAL_FIELDS[record])
    _check_solid(reader, what, values)
    values["shader"] = _index(reader, what, "shader", num_shaders)
    values["texture"] = _index(reader, what, "texture", len(textures))
    if values["texture"] != NONE:
        _check_texture(reader, what, textures[values["texture"]])
    if record is PolygonVisual:
        values["vertices"] = _vertices(reader, what)
        values["cull_back"] = bool(values["cull_back"])
    visual: Visual = record(**values)
    return visual


def _values(reader: _Reader, what: str, fields: tuple[Field, ...]) -> dict[str, Any]:
    names = STRUCTURE | {field.comment.lower() for field in fields}
    return {
        field.attribute: reader.take(f"{what} {field.comment}", field.comment, field.kind, names)
        for field in fields
    }


def _index(reader: _Reader, what: str, name: str, count: int) -> Any:
    return reader.take(f"{what} {name} index", f"{name} index", whole(NONE, count - 1))


def _check_solid(reader: _Reader, what: str, values: dict[str, Any]) -> None:
    if "file" in values:
        _check_file(reader, what, values["file"])
    if values.get("radius_base") == values.get("radius_top", 0) == 0:
        reader.fail_last(f"{what} has radius 0 at both ends, but one above 0 is needed")


def _check_file(reader: _Reader, what: str, name: str) -> None:
    file = reader.path.parent / name
    _check_place(reader, f"{what} File", name, file)
    if not file.is_file():
        reader.fail_last(f"{what} File is {name!r}, but a file beside it is needed")


def _check_place(reader: _Reader, what: str, name: str, file: Path) -> None:
    """An untrusted scene must not read arbitrary files of this machine."""
    if not may_read(file, reader.path.parent, SHIPPED):
        reader.fail_last(
            f"{what} is {name!r}, which lies outside the scene's folder; give --allow-outside"
        )


def _check_texture(reader: _Reader, what: str, name: str) -> None:
    _check_place(reader, f"{what} texture", name, reader.path.parent / name)
    found = find_texture(name, reader.path.parent)
    if found is None:
        reader.fail_last(
            f"{what} has texture {name!r}, but an image of that name beside the scene or one "
            "of recon's own is needed"
        )
    _check_place(reader, f"{what} texture", name, found)


def _vertices(reader: _Reader, what: str) -> tuple[Vertex, ...]:
    count = reader.take(f"{what} vertex count", "Vertex count", whole(3))
    rows = (reader.take(f"{what} vertex {n}", "", VERTEX) for n in range(count))
    return tuple(Vertex(position=r[:3], colour=r[3:7], uv=r[7:]) for r in rows)


def write_scene(scene: Scene, path: str | Path) -> None:
    """Write a geometry file that `read_scene` reads back as the same scene."""
    Path(path).write_text("\n".join(_lines(scene)) + "\n", encoding="utf-8")


def _lines(scene: Scene) -> Iterator[str]:
    for name in ("shader", "texture", "visual"):
        yield from (f"# {name.capitalize()} count", str(len(getattr(scene, f"{name}s"))))
    for number, shader in enumerate(scene.shaders):
        yield f"# SHADER {number}"
        yield from _field_lines(shader, SHADER_FIELDS)
    yield from scene.textures
    for number, visual in enumerate(scene.visuals):
        yield from (f"# VISUAL {number}", "# Visual type", visual.kind)
        yield from _field_lines(visual, VISUAL_FIELDS[type(visual)])
        yield from ("# Shader index", str(visual.shader), "# Texture index", str(visual.texture))
        if isinstance(visual, PolygonVisual):
            yield from _vertex_lines(visual)


def _field_lines(record: Shader | Visual, fields: tuple[Field, ...]) -> Iterator[str]:
    for field in fields:
        value = getattr(record, field.attribute)
        yield f"# {field.comment}"
        yield value if isinstance(record, MeshVisual) else _text(value)


def _vertex_lines(visual: PolygonVisual) -> Iterator[str]:
    yield from ("# Vertex count", str(len(visual.vertices)))
    yield from ("# Vertex data", "# x y z r g b a tu tv")
    for vertex in visual.vertices:
        yield _text((*vertex.position, *vertex.colour, *vertex.uv))


def _text(value: float | int | tuple[float, ...]) -> str:
    values = value if isinstance(value, tuple) else (value,)
    return " ".join(repr(int(v)) if v == int(v) else repr(v) for v in values)
