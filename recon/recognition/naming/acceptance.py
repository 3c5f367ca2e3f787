"""Description in words of what a kind of a catalogue accepts."""

from collections.abc import Iterator

from recon.recognition.naming.kinds import Kind, PartRule, Range, Sizes

PLACES = {"on": "on it", "beside": "beside it", "under": "under it"}


def accepted(kind: Kind) -> list[str]:
    """One line per requirement of a kind."""
    return list(_lines(kind))


def _lines(kind: Kind) -> Iterator[str]:
    if kind.learned is not None:
        yield from _learned_lines(kind)
    for number, part in enumerate(kind.parts):
        yield _part_line(part, is_first=number == 0)
    if kind.ratio is not None:
        yield f"radius of the lowest part over that of the next {_range(kind.ratio)}"
    if kind.slenderness is not None:
        yield f"height over its largest radius {_range(kind.slenderness)}"
    if kind.elongation is not None:
        yield f"longer side of its footprint over the shorter one {_range(kind.elongation)}"
    sizes = _sizes(kind.size)
    if sizes:
        yield f"in all {sizes}"
    if kind.min_seen > 0:
        yield f"at least {kind.min_seen:.0%} of its surface seen"


def _learned_lines(kind: Kind) -> Iterator[str]:
    assert kind.learned is not None
    groups = kind.learned.groups
    count = len(next(iter(groups.values())).examples)
    yield f"similar to one of {count} examples in {', '.join(groups)}"
    yield f"distance at most {kind.learned.threshold:g} times the usual distance"


def _part_line(part: PartRule, is_first: bool) -> str:
    low, high = part.count
    number = "" if (low, high) == (1, 1) else f"{low} to {high} x "
    words = [f"{number}{part.role}: {' or '.join(part.shapes)}"]
    if not is_first:
        words.append(PLACES[part.place])
    if part.slenderness is not None:
        of = "extent along the floor" if "plane" in part.shapes else "radius"
        words.append(f"height over {of} {_range(part.slenderness)}")
    if part.tilt_deg is not None:
        words.append(f"tilted by {_range(part.tilt_deg)} degrees")
    if part.square:
        words.append("at right angles")
    if part.share is not None:
        words.append(f"share of the cells {_range(part.share)}")
    if part.level is not None:
        words.append(f"middle at {_range(part.level)} of the height")
    if part.hue_deg is not None:
        words.append(f"hue {part.hue_deg[0]:g} to {part.hue_deg[1]:g} degrees")
    sizes = _sizes(part.size)
    return ", ".join([*words, sizes] if sizes else words)


def _sizes(sizes: Sizes) -> str:
    return ", ".join(f"{name} {_range(limits)} m" for name, limits in sizes.given.items())


def _range(limits: Range) -> str:
    return f"{limits[0]:g} to {limits[1]:g}"
