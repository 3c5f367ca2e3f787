"""Key-value documents of calibration tools: YAML, OpenCV's dialects of it, XML, JSON."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from recon.errors import InputError
from recon.sequences.text import read_text

Array = NDArray[np.float64]
Document = Mapping[str, Any]

MAX_BYTES = 1 << 21
"""Maximum size of a calibration file; one with a hundred board views has a tenth."""
MAX_DEPTH = 32
MAX_NODES = 300_000
"""Maximum number of nodes after alias expansion."""

_Safe: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Loader(_Safe):  # type: ignore[misc]  # PyYAML ships no types
    """Plain YAML and OpenCV's two kinds of matrix; nothing is executed."""


def _matrix_node(loader: Any, node: yaml.MappingNode) -> Array:
    fields = loader.construct_mapping(node, deep=True)
    return _matrix_of(fields)


def _matrix_of(fields: Document) -> Array:
    shape = fields.get("sizes") or (fields["rows"], fields["cols"])
    return np.array([float(value) for value in fields["data"]]).reshape(shape)


for _name in ("opencv-matrix", "opencv-nd-matrix"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_name}", _matrix_node)


def read_document(path: Path) -> Document:
    """The keys of a file: XML if it starts with "<", else YAML (which includes JSON).

    Raises
    ------
    InputError
        With the line that is neither, or if it is nested or repeated excessively.
    """
    text = read_text(path, MAX_BYTES)
    document = _xml(path, text) if text.lstrip()[:1] == "<" else _yaml(path, text)
    if not isinstance(document, dict):
        raise InputError(f"{path} holds no keys, but a calibration is needed")
    return {str(key): value for key, value in document.items()}


def _yaml(path: Path, text: str) -> Any:
    lines = ["" if re.match(r"%YAML|---\s*$", line) else line for line in text.splitlines()]
    plain = "\n".join(lines)
    try:
        _check_extent(plain)
        return yaml.load(plain, _Loader)  # a SafeLoader
    except InputError as error:
        raise InputError(f"{path} {error}") from error
    except (yaml.YAMLError, KeyError, ValueError, TypeError, AttributeError) as error:
        mark = getattr(error, "problem_mark", None)
        line = f", line {mark.line + 1}" if mark else ""
        raise InputError(f"{path}{line}: this is not a calibration in YAML") from error


def _check_extent(text: str) -> None:
    """Limit the depth and the number of nodes, aliases expanded, before any is built."""
    depth = nodes = 0
    open_anchors: list[tuple[str | None, int]] = []
    sizes: dict[str, int] = {}
    for event in yaml.parse(text, _Loader):
        if isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
            depth += 1
            open_anchors.append((event.anchor, nodes))
        elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            depth -= 1
            anchor, before = open_anchors.pop()
            sizes[anchor or ""] = nodes - before
        elif isinstance(event, yaml.AliasEvent):
            nodes += sizes.get(event.anchor, 1)
        nodes += 1
        if depth > MAX_DEPTH or nodes > MAX_NODES:
            raise InputError("is nested or repeated too much for a calibration")


def _xml(path: Path, text: str) -> Any:
    if re.search(r"<!(DOCTYPE|ENTITY)", text):
        raise InputError(f"{path} defines XML entities, which no calibration needs")
    try:
        return _xml_value(ET.fromstring(text))
    except (ET.ParseError, KeyError, ValueError, TypeError) as error:
        reason = str(error).partition("\n")[0]
        raise InputError(f"{path} is not a calibration in XML ({reason:.80})") from error


def _xml_value(element: ET.Element, depth: int = 0) -> Any:
    """A value of OpenCV's XML: a matrix, keys, a list of `_`, numbers or a text."""
    if depth > MAX_DEPTH:
        raise ValueError("it is nested too deeply for a calibration")
    if element.find("data") is not None and element.find("rows") is not None:
        values = {child.tag: (child.text or "").split() for child in element}
        return _matrix_of(
            {"rows": int(values["rows"][0]), "cols": int(values["cols"][0]), "data": values["data"]}
        )
    if len(element):
        is_list = all(child.tag == "_" for child in element)
        items = [_xml_value(child, depth + 1) for child in element]
        names = [child.tag for child in element]
        return items if is_list else dict(zip(names, items, strict=True))
    return _xml_scalar(element.text or "")


def _xml_scalar(text: str) -> Any:
    """A number, several numbers, or the text itself."""
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        return text.strip().strip('"')
    return numbers[0] if len(numbers) == 1 else numbers


def numbers(value: Any, shape: tuple[int, ...]) -> Array:
    """A matrix in any notation: OpenCV's, nested rows, {rows, cols, data}.

    Raises
    ------
    ValueError
        If the count does not match the shape.
    """
    data = value.get("data") if isinstance(value, dict) else value
    try:
        return np.array(data, dtype=np.float64).reshape(shape)
    except (ValueError, TypeError, OverflowError) as error:
        shown = "an array" if isinstance(data, np.ndarray) else f"{data!r:.60}"
        raise ValueError(f"{shown} is given, but numbers of shape {shape} are needed") from error


def whole(value: Any, name: str) -> int:
    """A positive integer.

    Raises
    ------
    ValueError
        If it is not one.
    """
    number = float(numbers(value, (1,))[0])
    if not (0 < number < 1e6 and number == round(number)):
        raise ValueError(f"{name} is {number:g}, but a positive whole number is needed")
    return int(number)
