"""The layout of OctoMap's files, checked before OctoMap reads them.

A node lists its children; nodes follow depth first. A file is complete if the pending children run
out exactly at its end.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from recon.errors import InputError

_MAX_HEADER_BYTES = 10_000

# After the log-odds and the optional colour: one bit per child.
_NODES = {
    "OcTree": np.dtype([("log_odds", "<f4"), ("children", "u1")]),
    "ColorOcTree": np.dtype([("log_odds", "<f4"), ("colour", "u1", 3), ("children", "u1")]),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """The tree of a file as described by its header."""

    kind: str
    num_nodes: int
    cell_size: float
    """World units."""


def check_whole(path: Path) -> Header:
    """The header of a complete file.

    Raises
    ------
    InputError
        If it is of another kind, truncated or modified.
    """
    content = path.read_bytes()
    try:
        header, start = _header(content[:_MAX_HEADER_BYTES])
        inner, found = _children(content[start:], header.kind, path.suffix.lower() == ".bt")
    except (ValueError, KeyError, IndexError) as error:
        raise InputError(f"{path}: not a whole OctoMap file ({error})") from error
    # Pending nodes after each node: zero only after the last.
    to_come = 1 + np.cumsum(inner - 1)
    if found != header.num_nodes or (to_come[:-1] <= 0).any() or to_come[-1:].any():
        raise InputError(f"{path}: {header.num_nodes} nodes are claimed, but some are missing")
    return header


def _header(content: bytes) -> tuple[Header, int]:
    """The header, and where the nodes start."""
    if not content.startswith(b"# Octomap OcTree"):
        raise ValueError("wrong first line")
    text, mark, _ = content.partition(b"\ndata\n")
    if not mark:
        raise ValueError("its header has no end")
    lines = [line.split() for line in text.decode("ascii").splitlines()]
    values = {words[0]: words[1] for words in lines if len(words) == 2 and words[0] != "#"}
    cell_size = float(values["res"])
    # Smaller or larger sizes cannot be distinguished, or overflow.
    if not 1e-9 <= cell_size <= 1e9:
        raise ValueError(f"its cells have size {cell_size}")
    header = Header(kind=values["id"], num_nodes=int(values["size"]), cell_size=cell_size)
    return header, len(text) + len(mark)


def _children(content: bytes, kind: str, is_binary: bool) -> tuple[NDArray[np.int64], int]:
    """Number of children of each node in the file, and the total number of nodes."""
    if not is_binary:
        nodes = np.frombuffer(content, _NODES[kind])
        return np.bitwise_count(nodes["children"]).astype(np.int64), len(nodes)
    # Two bits per child: 0 unknown, 1 and 2 leaves, 3 a node that follows.
    words = np.frombuffer(content, "<u2")
    pairs = (words[:, None] >> np.arange(0, 16, 2)) & 3
    num_nodes = int(1 + (pairs != 0).sum()) if len(words) else 0
    return (pairs == 3).sum(axis=1), num_nodes
