"""The edge table: signed outlines add up to it, whatever the soup is like."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from bodyschema.vision.edges import edge_table


def outline(faces: np.ndarray, sign: np.ndarray) -> Counter[tuple[int, int]]:
    """Directed edges of all faces, turned by their sign; u->v counts against v->u."""
    total: Counter[tuple[int, int]] = Counter()
    for face, s in zip(faces.tolist(), sign.tolist(), strict=True):
        for u, v in zip(face, face[1:] + face[:1], strict=True):
            total[min(u, v), max(u, v)] += s if u < v else -s
    return +total | Counter({edge: w for edge, w in total.items() if w < 0})


def from_table(table: np.ndarray, sign: np.ndarray) -> Counter[tuple[int, int]]:
    """The same from the table."""
    s, total = np.append(sign, 0), Counter[tuple[int, int]]()
    for u, v, f, g in table.tolist():
        w = int(s[f] - s[g])
        total[min(u, v), max(u, v)] += w if u < v else -w
    return +total | Counter({edge: w for edge, w in total.items() if w < 0})


@pytest.mark.parametrize("seed", range(20))
def test_signed_outlines_add_up_to_the_table(seed: int) -> None:
    """Few vertices and many faces: edges with one, three and wrongly wound faces are common."""
    rng = np.random.default_rng(seed)
    faces = np.array([rng.choice(7, 3, replace=False) for _ in range(rng.integers(1, 25))])
    table = edge_table(faces, none=len(faces))
    for _ in range(5):
        sign = rng.choice([-1, 0, 1], len(faces))
        assert from_table(table, sign) == outline(faces, sign)


def test_a_closed_surface_has_one_entry_an_edge() -> None:
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    table = edge_table(faces, none=4)
    assert len(table) == 6
    assert (table[:, 3] < 4).all()


def test_a_hole_leaves_single_entries_in_the_direction_of_their_face() -> None:
    table = edge_table(np.array([[2, 1, 0]]), none=1)
    assert sorted(map(tuple, table.tolist())) == [(0, 2, 0, 1), (1, 0, 0, 1), (2, 1, 0, 1)]
