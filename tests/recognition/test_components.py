"""Components: gaps are closed, stacked parts joined, neighbours kept separate."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from recon.recognition.adjacency import neighbours
from recon.recognition.connectivity import grouped, in_order_of_appearance, joined, stacked
from recon.recognition.unions import agreed_roots


def block(low, high):
    axes = [np.arange(a, b) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)


def connected(cells, reach):
    return joined(neighbours(cells, reach), len(cells))


def test_gap_of_one_cell_is_closed_by_a_reach_of_two():
    cells = np.concatenate([block((0, 0, 0), (2, 2, 2)), block((3, 0, 0), (5, 2, 2))])
    assert connected(cells, 1).max() == 1
    assert connected(cells, 2).max() == 0


def test_cells_that_touch_at_a_corner_are_neighbours():
    assert connected(np.array([[0, 0, 0], [1, 1, 1]]), 1).max() == 0


@pytest.mark.parametrize("reach", [1, 2, 3])
@pytest.mark.parametrize("spread", [[9, 9, 9], [1, 40, 3], [2**40, 9, 2**40]])
def test_pairs_of_neighbours_are_those_of_a_tree(reach, spread):
    rng = np.random.default_rng(reach)
    cells = np.unique(rng.integers(-5, 6, (200, 3)) * spread // 9, axis=0)
    cells = cells[rng.permutation(len(cells))]
    tree = cKDTree(cells).query_pairs(reach + 0.5, p=np.inf)
    pairs = neighbours(cells, reach)
    assert len(pairs) == len(tree)
    assert {tuple(sorted(pair)) for pair in pairs.tolist()} == tree


def test_components_are_numbered_by_their_first_cell():
    label = in_order_of_appearance(np.array([7, 7, -1, 2, 7, 2]))
    assert label.tolist() == [0, 0, -1, 1, 0, 1]


def test_no_cells_have_no_components():
    assert connected(np.empty((0, 3), np.int64), 1).shape == (0,)


def test_trunk_under_a_crown_is_joined_but_a_neighbour_is_not():
    crown = block((-8, 8, -8), (8, 12, 8))
    trunk, neighbour = block((-1, 0, -1), (1, 5, 1)), block((12, 0, -1), (14, 5, 1))
    cells = np.concatenate([crown, trunk, neighbour])
    label = stacked(cells + 0.5, connected(cells, 2), 12)
    assert label[0] == label[len(crown)]
    assert label[-1] != label[0]


def test_neighbours_stay_separate_inside_a_wide_bounding_box():
    wall = np.concatenate([block((0, 0, 0), (40, 6, 1)), block((0, 0, 0), (1, 6, 40))])
    cup = block((20, 0, 20), (22, 4, 22))
    cells = np.concatenate([wall, cup])
    label = stacked(cells + 0.5, connected(cells, 2), 12)
    assert label[-1] != label[0]


def test_groups_list_the_rows_of_each_label_but_not_unlabelled_ones():
    rows = grouped(np.array([2, 0, -1, 2, 0]), 4)
    assert [one.tolist() for one in rows] == [[1, 4], [], [0, 3], []]


@pytest.mark.parametrize(("num_for", "num_groups"), [(0, 2), (1, 2), (2, 1), (4, 1)])
def test_groups_join_only_where_enough_of_the_pairs_between_them_are_for_it(num_for, num_groups):
    inside = np.array([(0, 1), (0, 2), (1, 2), (3, 4), (3, 5), (4, 5)])
    between = np.array([(0, 3), (1, 4), (2, 5), (2, 3)])
    is_for = np.repeat([True, False], [6 + num_for, 4 - num_for])
    roots = agreed_roots(np.concatenate([inside, between]), is_for, 6, 0.3)
    assert len(set(roots)) == num_groups
    assert (roots[:3] == 0).all()
    assert len(set(roots[3:])) == 1
