"""Figures 9 to 16 and 18 to 21, Tables 1 and 3: disparity, its success, sub-pixel refinement."""

from collections.abc import Callable, Iterator
from functools import cache, partial

import cv2
import numpy as np
from numpy.typing import NDArray

from recon.mapping.sparse import match_sparse
from recon.records import Matches
from recon.settings import Settings, updated, with_preset
from recon.stereo.evaluation import evaluate
from recon.stereo.features import detect
from recon.stereo.matching.matching import match
from recon.stereo.subpixel import refine
from reproduction.drawing import disparity_over, sheet, show
from reproduction.entry import Absent, Entry, Result, Table, number, table
from reproduction.features import STAND_IN
from reproduction.pairs import TruePair, blocks, recorded

Pairs = dict[str, Callable[[], TruePair]]
PAIRS: Pairs = {
    "Blocks 1": partial(blocks, "Blocks 1"),
    "Blocks 2": partial(blocks, "Blocks 2"),
    "Venus": partial(recorded, "Venus"),
    "Sawtooth": partial(recorded, "Sawtooth"),
    "Tsukuba": partial(recorded, "Tsukuba"),
}
Printed = dict[str, tuple[int, int, int, int]]
"""The thesis's features, pairs, wrong pairs and per cent right."""
FIGURE_9: Printed = {"Blocks 1": (980, 537, 62, 90)}
TABLE_1: Printed = {"Blocks 2": (3847, 1265, 340, 73), "Venus": (1884, 1163, 65, 94),
           "Sawtooth": (4288, 2938, 140, 95), "Tsukuba": (4088, 2089, 352, 83)}  # fmt: skip
TABLE_3: Printed = {"Blocks 2": (3847, 1505, 206, 86), "Venus": (1884, 1310, 85, 94),
           "Sawtooth": (4288, 3079, 111, 96), "Tsukuba": (4088, 2350, 398, 83)}  # fmt: skip
HEAD = ("pair", "method", "features", "pairs", "wrong", "right, %")
RATIO = 0.8
"""Lowe's test: the best match of a descriptor must be so much nearer than the second."""
BETTER = (
    "More features are kept and ranked by confidence, neighbours support each other, and a "
    "whole row is cross checked: more pairs, nearly all of them right."
)


def entries() -> Iterator[Entry]:
    """List the entries of this part."""
    yield Entry(
        name="figure 9", title="Disparity of Blocks 1", difference=STAND_IN,
        make=partial(_disparity, "Blocks 1", FIGURE_9),
        thesis="537 pairs of 980 features, 62 of them wrong: 90 % right.",
    )  # fmt: skip
    yield Entry(
        name="figure 10", title="Sub-pixel refinement along an edge", difference=STAND_IN,
        thesis="Whole disparities are a staircase from 13 to 9 px; refined ones fall smoothly.",
        make=partial(_refinement, "Blocks 1"),
    )  # fmt: skip
    for figure, name in zip((11, 12, 13, 14), TABLE_1, strict=True):
        matched, wrong, success = TABLE_1[name][1:]
        yield Entry(
            name=f"figure {figure}", title=f"Disparity of {name}",
            make=partial(_disparity, name, TABLE_1),
            thesis=f"{matched} pairs, {wrong} of them wrong: {success} % right.",
            difference=STAND_IN if figure == 11 else BETTER,
        )  # fmt: skip
    yield Entry(
        name="table 1", title="Success by phase", make=partial(_success, "phase", TABLE_1),
        thesis="73 to 95 % of the matched pairs are right.", difference=BETTER,
    )  # fmt: skip
    yield Entry(
        name="figure 15", title="Sub-pixel refinement on Venus", make=partial(_refinement, "Venus"),
        thesis="Whole disparities stay at six; refined ones rise smoothly towards seven.",
        difference="The local frequency takes the place of the nominal wavelength (Eq 20).",
    )  # fmt: skip
    yield Entry(
        name="figure 16", title="One scale and three scales on Sawtooth", make=_one_and_three,
        thesis="Three scales give more points, and more reliable ones, than one.",
        difference="The same; the table counts it.",
    )  # fmt: skip
    for figure, name in zip(
        (18, 19, 20, 21), ("Venus", "Blocks 2", "Sawtooth", "Tsukuba"), strict=True
    ):
        yield Entry(
            name=f"figure {figure}", title=f"Phase and the probabilistic model on {name}",
            make=partial(_by_model, name),
            thesis=f"{TABLE_3[name][1]} pairs by the model, {TABLE_1[name][1]} by phase.",
            difference=f"{STAND_IN if figure == 19 else BETTER} Learned on Venus, it serves all.",
        )  # fmt: skip
    yield Entry(
        name="table 3", title="Success of the probabilistic model", difference=BETTER,
        thesis="83 to 96 % of the matched pairs are right, of more pairs than by phase.",
        make=partial(_success, "vonmises", TABLE_3),
    )  # fmt: skip


@cache
def _matched(name: str, matcher: str, preset: str = "default") -> tuple[int, Matches]:
    """Return the number of left features, and the matches, of a pair."""
    pair = PAIRS[name]()
    changes = {"matching": pair.search | {"matcher": matcher}}
    settings = updated(with_preset(Settings(), preset), changes)
    number_left = len(detect(pair.left, settings.features))
    return number_left, match_sparse(pair.left, pair.right, settings).matches


def _disparity(name: str, printed: Printed) -> Result:
    pair = PAIRS[name]()
    figure, axes = sheet(3)
    show(axes[0], pair.left, "left")
    show(axes[1], pair.right, "right")
    _, matches = _matched(name, "phase")
    disparity_over(axes[2], pair.truth_px.shape, matches, f"disparity, {len(matches)} pairs")
    return Result(figures=(figure,), tables=(_success_table("phase", printed, [name]),))


def _by_model(name: str) -> Result:
    figure, axes = sheet(2)
    pair = PAIRS[name]()
    rows: list[tuple[object, ...]] = []
    methods = {"phase": ("by phase", TABLE_1), "vonmises": ("by the model", TABLE_3)}
    for one, (matcher, (title, printed)) in zip(axes, methods.items(), strict=True):
        count, matches = _matched(name, matcher)
        disparity_over(one, pair.truth_px.shape, matches, f"{title}: {len(matches)} pairs")
        rows.append((name, f"the thesis, {title}", *printed[name]))
        rows.append(_row(pair, name, f"recon, {title}", count, matches))
    return Result(figures=(figure,), tables=(table(HEAD, rows),))


def _success(matcher: str, printed: Printed) -> Result:
    return Result(tables=(_success_table(matcher, printed, list(printed)),))


def _success_table(matcher: str, printed: Printed, names: list[str]) -> Table:
    """Tabulate features, pairs, wrong pairs and success of the thesis, recon and the peers."""
    rows: list[tuple[object, ...]] = []
    for name in names:
        rows.append((name, "the thesis", *printed[name]))
        try:
            pair = PAIRS[name]()
        except Absent as absent:
            rows.append((name, str(absent), "-", "-", "-", "-"))
            continue
        for title, preset in (("recon", "default"), ("recon, preset thesis", "thesis")):
            rows.append(_row(pair, name, title, *_matched(name, matcher, preset)))
        count, matches = _matched(name, matcher)
        kept = matches.select(slice(printed[name][1]))
        rows.append(_row(pair, name, "recon, as many pairs as the thesis", count, kept))
        rows.extend(_row(pair, name, title, count, peer) for title, count, peer in _peers(pair))
    return table(HEAD, rows)


def _row(
    pair: TruePair, name: str, title: str, num_features: int, matches: Matches
) -> tuple[object, ...]:
    judged = evaluate(matches, pair.truth_px, pair.quantisation_px).as_metrics()
    right = number(judged["success_all"], 1)
    return name, title, num_features, len(matches), judged["num_mismatches"], right


def _peers(pair: TruePair) -> Iterator[tuple[str, int, Matches]]:
    """Match with StereoSGBM and StereoBM at recon's features, and with SIFT at its own."""
    settings = updated(Settings(), {"matching": pair.search})
    points = detect(pair.left, settings.features).points_px
    yield "StereoSGBM, at recon's features", len(points), _at(points, _block_matched(pair, True))
    yield "StereoBM, at recon's features", len(points), _at(points, _block_matched(pair, False))
    yield _sift(pair)


def _block_matched(pair: TruePair, is_semi_global: bool) -> NDArray[np.float64]:
    left, right = (cv2.cvtColor(i, cv2.COLOR_RGB2GRAY) if i.ndim == 3 else i
                   for i in (pair.left, pair.right))  # fmt: skip
    low, high = pair.search["min_disparity"], pair.search["max_disparity"]
    number_of = -(-(high - low + 1) // 16) * 16
    if is_semi_global:
        matcher = cv2.StereoSGBM.create(low, number_of, 5, 200, 800, 1, 0, 10, 100, 2)
    else:
        matcher = cv2.StereoBM.create(number_of, 15)
        matcher.setMinDisparity(low)
    found = matcher.compute(left, right).astype(np.float64) / 16.0
    return np.where(found < low, np.nan, found)


def _at(points_px: NDArray[np.float64], disparity_px: NDArray[np.float64]) -> Matches:
    u, v = points_px.astype(np.intp).T
    found = disparity_px[v, u]
    return _matches(points_px[np.isfinite(found)], found[np.isfinite(found)])


def _matches(points_px: NDArray[np.float64], disparity_px: NDArray[np.float64]) -> Matches:
    index = np.arange(len(points_px), dtype=np.int32)
    one = np.ones(len(points_px))
    return Matches(
        points_px=points_px, disparity_px=disparity_px, sigma_px=one, score=one,
        index_left=index, index_right=index,
    )  # fmt: skip


def _sift(pair: TruePair) -> tuple[str, int, Matches]:
    """Match SIFT with Lowe's ratio test, along the row and in the search range."""
    sift = cv2.SIFT.create()
    (left, ours), (right, theirs) = (
        sift.detectAndCompute(i, None) for i in (pair.left, pair.right)
    )
    low, high = pair.search["min_disparity"], pair.search["max_disparity"]
    points, found = [], []
    for best, second in cv2.BFMatcher().knnMatch(ours, theirs, k=2):
        a, b = left[best.queryIdx].pt, right[best.trainIdx].pt
        is_clear = best.distance < RATIO * second.distance
        if is_clear and abs(a[1] - b[1]) <= 1.0 and low <= a[0] - b[0] <= high:
            points.append((round(a[0]), round(a[1])))
            found.append(a[0] - b[0])
    return (
        "SIFT, at its own",
        len(left),
        _matches(np.array(points, dtype=np.float64).reshape(-1, 2), np.array(found)),
    )


def _refinement(name: str) -> Result:
    """Draw integer, refined and true disparity along the longest edge of features."""
    pair = PAIRS[name]()
    settings = updated(Settings(), {"matching": pair.search})
    left, right = (detect(image, settings.features) for image in (pair.left, pair.right))
    whole = match(left, right, settings.matching)
    refined = refine(whole, left, right)
    u, v = whole.points_px.astype(np.intp).T
    rows = _longest_edge(np.round(refined.disparity_px, 1), u, v)
    figure, axes = sheet(1, width=7.0)
    steps = np.arange(len(rows))
    axes[0].plot(steps, whole.disparity_px[rows], "*", color="#555555", label="whole pixels")
    axes[0].plot(steps, refined.disparity_px[rows], "-", color="#0072b2", label="refined")
    axes[0].plot(steps, pair.truth_px[v[rows], u[rows]], "--", color="#d55e00", label="truth")
    axes[0].set(xlabel="feature point along the edge", ylabel="disparity, px")
    axes[0].legend(frameon=False)
    errors = [np.abs(m.disparity_px - pair.truth_px[v, u]) for m in (whole, refined)]
    near = errors[0] <= 1.0
    medians = [number(float(np.nanmedian(error[near])), 3) for error in errors]
    return Result(
        figures=(figure,),
        tables=(table(("", "whole", "refined"), [("median error of right pairs, px", *medians)]),),
    )


def _longest_edge(
    disparity_px: NDArray[np.float64], u: NDArray[np.intp], v: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Follow the edge whose disparity changes most steadily; return its matches."""
    image = np.zeros((v.max() + 1, u.max() + 1), dtype=np.uint8)
    image[v, u] = 1
    _, labels = cv2.connectedComponents(image, connectivity=8)
    of_match = labels[v, u]
    edges = [np.flatnonzero(of_match == i) for i in np.unique(of_match)]
    ordered = [rows[np.argsort((u + v)[rows], kind="stable")] for rows in edges if len(rows) >= 30]
    return max(ordered, key=lambda rows: _steadiness(disparity_px[rows]))


def _steadiness(disparity_px: NDArray[np.float64]) -> float:
    """Slope of a line through the disparities, in units of its residual."""
    steps = np.arange(len(disparity_px))
    line = np.polyval(np.polyfit(steps, disparity_px, 1), steps)
    return float(np.ptp(line)) / (float(np.std(disparity_px - line)) + 0.05)


def _one_and_three() -> Result:
    pair = PAIRS["Sawtooth"]()
    figure, axes = sheet(2)
    rows = []
    for one, (title, widths) in zip(
        axes, {"one scale": (2.0,), "three scales": (2.0, 4.0, 6.0)}.items(), strict=True
    ):
        changes = {"features": {"widths_px": widths}, "matching": pair.search}
        settings = updated(with_preset(Settings(), "thesis"), changes)
        matches = match_sparse(pair.left, pair.right, settings).matches
        disparity_over(one, pair.truth_px.shape, matches, f"{title}: {len(matches)} pairs")
        rows.append(_row(pair, title, "", len(detect(pair.left, settings.features)), matches))
    head = ("scales", "", "features", "pairs", "wrong", "right, %")
    return Result(figures=(figure,), tables=(table(head, rows),))
