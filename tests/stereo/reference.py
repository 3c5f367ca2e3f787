"""Reference implementation of scores, support and sides, as documented, pixel by pixel."""

import numpy as np

RADIUS, SIDE_RADIUS, SPREAD, RIGID, GAP, CONTRAST = 7, 10, 5.0, 3.0, 1.5, 20.0
SLACK, RIVAL_GAP, DIRECTIONS = 0.9, 3, 16
WHOLE, ONE = 1 << 15, 32_000
"""Units of the members' shares and scores, which are whole numbers, and so are the sums."""


class Pair:
    """Two images' responses (H, W, C) complex, candidates, and the left brightness."""

    def __init__(self, left, right, search):
        self.base, self.other = (responses(features) for features in (left, right))
        self.mask, self.other_mask = left.candidate_mask, right.candidate_mask
        self.grey = left.grey.astype(float)
        self.search = search
        self.cache = {}

    def is_open(self, v, u):
        """Mark the shifts of a pixel that lead to a candidate."""
        height, width = self.other_mask.shape
        row = v + self.search.row_shift
        columns = u + self.search.first + np.arange(self.search.num_shifts)
        found = np.zeros(len(columns), bool)
        if 0 <= row < height:
            inside = (columns >= 0) & (columns < width)
            found[inside] = self.other_mask[row, columns[inside]]
        return found

    def scores(self, v, u):
        """Compute exact and slack scores of a member at every shift."""
        if (v, u) not in self.cache:
            self.cache[v, u] = self._scores(v, u)
        return self.cache[v, u]

    def _scores(self, v, u):
        exact = np.zeros(self.search.num_shifts)
        height, width = self.mask.shape
        if 0 <= v < height and 0 <= u < width and self.mask[v, u]:
            a = self.base[v, u]
            for k in np.flatnonzero(self.is_open(v, u)):
                b = self.other[v + self.search.row_shift, u + self.search.first + k]
                largest = np.maximum(np.abs(a) ** 2, np.abs(b) ** 2)
                exact[k] = max(0.0, np.mean((a * b.conj()).real / largest))
        exact = rounded(ONE * exact)
        around = np.pad(exact, 1)
        beside = np.maximum(around[:-2], around[2:])
        return exact, np.maximum(exact, rounded(rounded(SLACK * WHOLE) * beside / WHOLE))

    def is_member(self, v, u):
        if self.search.every == 2:
            return v % 2 == 0 and u % 2 == 0
        return (v + u) % 2 == 0

    def mean(self, v, u, radius, weigh):
        """Compute the weighted mean of the members' scores."""
        weights, scores = [], []
        for dv in range(-radius, radius + 1):
            for du in range(-radius, radius + 1):
                r_sq = dv * dv + du * du
                if r_sq > radius**2 or not self.is_member(v + dv, u + du):
                    continue
                weights.append(np.exp(-r_sq / (2 * SPREAD**2)) * weigh(dv, du))
                scores.append(self.scores(v + dv, u + du)[r_sq > RIGID**2])
        shares = rounded((WHOLE - 1) * np.array(weights) / np.sum(weights))
        return rounded(shares[:, None] * np.array(scores) / WHOLE).sum(axis=0) / ONE

    def support(self, v, u):
        """Compute the support of every shift; -inf if it leads to no candidate."""
        height, width = self.grey.shape

        def alike(dv, du):
            there = self.grey[np.clip(v + dv, 0, height - 1), np.clip(u + du, 0, width - 1)]
            return np.exp(-abs(there - self.grey[v, u]) / CONTRAST)

        return np.where(self.is_open(v, u), self.mean(v, u, RADIUS, alike), -np.inf)

    def side(self, v, u, best, orientation):
        """Compare the evidence for the best shift in the half disc ahead and the one behind."""
        angle = (min(int(orientation * DIRECTIONS / np.pi), DIRECTIONS - 1) + 0.5) / DIRECTIONS
        normal = np.cos(np.pi * angle), np.sin(np.pi * angle)
        evidence = []
        for sign in (1, -1):
            average = self.mean(
                v, u, SIDE_RADIUS,
                lambda dv, du, s=sign: s * (du * normal[0] + dv * normal[1]) >= GAP,
            )  # fmt: skip
            evidence.append(average[best] - 0.5 * average[best + 2 :].max(initial=0.0))
        return evidence[0] - evidence[1]


def rounded(numbers):
    return np.floor(numbers + 0.5)


def responses(features):
    planes = features.planes[..., : features.grey.shape[1]]
    whole = planes[:, :, :, 0] + 1j * planes[:, :, :, 1]
    return np.moveaxis(whole.reshape(len(planes), -1, planes.shape[-1]), 1, 2)


def best_of(support):
    """Find the best shift, its support, and the support of the best rival relative to it."""
    best = int(np.argmax(support))
    others = np.abs(np.arange(len(support)) - best) >= RIVAL_GAP
    rival = max(support[others].max(initial=0.0), 0.0)
    return best, support[best], rival / support[best]
