"""The silhouette of one hypothesis in one view, from the edges where the surface turns away.

No triangle is filled. Let s(f) = +1 for a face that shows its outer side to the eye and -1 for one
that does not; turning the outline of every face by its sign gives all of them the same sense of
rotation in the image. The sum of these outlines has the weight s(f) - s(g) on the edge between f
and g, which is zero but for the contour edges. Its winding number at a pixel is the number of
triangles over it, counted with one sign, so

    winding number != 0  <=>  some triangle covers the centre of the pixel.

A contour edge from (x_lo, y_lo) to (x_hi, y_hi) crosses the rows ceil(y_lo) .. ceil(y_hi) - 1 at
x = x_lo + (r - y_lo) g, g = (x_hi - x_lo) / (y_hi - y_lo); ceil(x) is the first pixel right of it.
It is always followed from its lower end, so that two faces that share it get the same columns.
Columns are clamped to 0 .. W and never dropped, so that the winding is right at the border.

A crossing is stored as 16 column + weight + 8, one number that sorts by column. Row r has
`capacity` places, of which the first holds -1, a guard for sorting; full[r] is the number taken.

All coordinates are float32 and no sum depends on an order; what is added later are integers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel
from bodyschema.vision.near_plane import clip_piece
from bodyschema.vision.scratch import Scratch
from bodyschema.vision.surface import Columns

Floats = NDArray[np.float32]
Signs = NDArray[np.int8]


@kernel
def trace(
    columns: Columns, T: Floats, lens: Floats, near: np.float32, width: int, memory: Scratch
) -> int:
    """Fill the rows of one view with crossings; returns how many found no place.

    Args:
        columns: of the surface.
        T: (n_pieces, 3, 4) T_cam_piece.
        lens: (4,) f_x, f_y, c_x, c_y.
        near: m; what is nearer to the plane of the camera is cut off.
        width: pixels.
        memory: as left by the last view.
    """
    _, n = outline(columns, T, lens, near, memory)
    lost: int = cross_rows(n, width, memory)
    return lost


@kernel
def outline(
    columns: Columns, T: Floats, lens: Floats, near: np.float32, memory: Scratch
) -> tuple[int, int]:
    """Segments of the contour that cross a row: first those that the near plane cuts, c of them,
    then contour edges, of which number i is found[i - c]. Returns c and the number of all."""
    U, V, S = memory.U, memory.V, memory.S
    n = 0
    for b in range(T.shape[0]):
        v0, v1 = columns.vo[b], columns.vo[b + 1]
        f0, f1 = columns.fo[b], columns.fo[b + 1]
        VX, VY, VZ = columns.VX[v0:v1], columns.VY[v0:v1], columns.VZ[v0:v1]
        NX, NY, NZ = columns.NX[f0:f1], columns.NY[f0:f1], columns.NZ[f0:f1]
        turn(NX, NY, NZ, columns.ND[f0:f1], T[b], S[f0:f1])
        if project(VX, VY, VZ, T[b], lens, near, U[v0:v1], V[v0:v1]):
            n = clip_piece(columns, b, T[b], lens, near, memory, n)
    return n, int(contour(columns, memory, n))


@kernel
def project(
    VX: Floats,
    VY: Floats,
    VZ: Floats,
    T: Floats,
    lens: Floats,
    near: np.float32,
    U: Floats,
    V: Floats,
) -> np.int32:
    """Pixels of the vertices of one piece; returns how many are nearer than `near`."""
    a, b, c, d = T[0, 0], T[0, 1], T[0, 2], T[0, 3]
    e, f, g, h = T[1, 0], T[1, 1], T[1, 2], T[1, 3]
    i, j, k, m = T[2, 0], T[2, 1], T[2, 2], T[2, 3]
    f_x, f_y, c_x, c_y = lens[0], lens[1], lens[2], lens[3]
    one, close = np.float32(1), np.int32(0)
    for v in range(VX.shape[0]):
        x, y, z = VX[v], VY[v], VZ[v]
        Z = i * x + j * y + k * z + m
        nearness = one / Z
        U[v] = f_x * (a * x + b * y + c * z + d) * nearness + c_x
        V[v] = f_y * (e * x + f * y + g * z + h) * nearness + c_y
        close += np.int32(near > Z)
    return close


@kernel
def turn(NX: Floats, NY: Floats, NZ: Floats, ND: Floats, T: Floats, S: Signs) -> None:
    """Signs of the faces of one piece, seen from the eye e = -R^T t."""
    t0, t1, t2 = T[0, 3], T[1, 3], T[2, 3]
    ex = -(T[0, 0] * t0 + T[1, 0] * t1 + T[2, 0] * t2)
    ey = -(T[0, 1] * t0 + T[1, 1] * t1 + T[2, 1] * t2)
    ez = -(T[0, 2] * t0 + T[1, 2] * t1 + T[2, 2] * t2)
    for f in range(NX.shape[0]):
        outside = NX[f] * ex + NY[f] * ey + NZ[f] * ez > ND[f]
        S[f] = np.int8(1) if outside else np.int8(-1)


@kernel
def contour(columns: Columns, memory: Scratch, n: int) -> np.int64:
    """Append the contour edges that cross a row to the n segments there are; returns how many."""
    E0, E1, S, found = columns.E0, columns.E1, memory.S, memory.found
    taken = np.uint64(0)
    for e in range(E0.shape[0]):  # no branch: nobody can guess which
        found[taken] = e
        taken += np.uint64(S[E0[e]] != S[E1[e]])
    U, V, first, rows = memory.U, memory.V, memory.first, memory.rows
    top, bottom = np.float32(0), np.float32(memory.full.shape[0])
    end = np.uint64(n)
    for i in range(taken):
        e = found[i]
        u, v = columns.EU[e], columns.EV[e]
        down = V[u] > V[v]
        x_lo, y_lo = (U[v], V[v]) if down else (U[u], V[u])
        x_hi, y_hi = (U[u], V[u]) if down else (U[v], V[v])
        w = np.int32(S[E0[e]]) - np.int32(S[E1[e]])
        begin, stop = max(np.ceil(y_lo), top), min(np.ceil(y_hi), bottom)
        g = (x_hi - x_lo) / (y_hi - y_lo)
        first[end], rows[end] = np.int32(begin), np.int32(stop - begin)
        memory.x[end], memory.g[end] = x_lo + (begin - y_lo) * g, g
        memory.weight[end] = np.int32(8) - w if down else np.int32(8) + w
        found[end - np.uint64(n)] = e  # the edge of each segment that is kept
        end += np.uint64(stop > begin)
    return np.int64(end)


@kernel
def cross_rows(n: int, width: int, memory: Scratch) -> int:
    """Put the crossings of n segments into their rows; returns how many found no place."""
    crossings, full = memory.crossings, memory.full
    capacity = np.uint32(crossings.shape[0] // full.shape[0])
    left, right, lost = np.int32(0), np.int32(width), 0
    for i in range(n):
        x, g, weight = memory.x[i], memory.g[i], memory.weight[i]
        r = np.uint32(memory.first[i])
        for j in range(memory.rows[i]):
            column = min(max(np.int32(np.ceil(x + np.float32(j) * g)), left), right)
            place = full[r]
            if place < capacity:
                crossings[r * capacity + place] = (column << 4) | weight
                full[r] = place + np.uint32(1)
            else:
                lost += 1
            r += np.uint32(1)
    return lost
