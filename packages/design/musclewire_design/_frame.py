"""Plane frames of straight beams by the direct stiffness method: displacements of the joints if one of them is pulled.

Two joints make a beam; each joint has displacements along x and y and a rotation. Euler and Bernoulli's beam with
stretch; Przemieniecki 1968, Theory of Matrix Structural Analysis, chapter 5.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError


def chain_stiffness_n_per_m(
    joints_m: FloatArray, bending_n_m2: float, stretching_n: float, *, guided: bool = False
) -> float:
    """Return the force [N] per metre that pulls the last joint of a chain of beams along y, the first being clamped.

    ``joints_m`` (n, 2) are the chain's joints; ``bending_n_m2`` is E I, ``stretching_n`` is E A. The last joint is free
    to turn and to move along x, or neither when ``guided``. Raises CallerError for fewer than two joints.
    """
    joints = np.asarray(joints_m, dtype=np.float64)
    if len(joints) < 2:
        raise CallerError(f"a chain of beams has at least two joints, not {len(joints)}")
    size = 3 * len(joints)
    pulled, held = size - 2, [0, 1, 2, *([size - 3, size - 1] if guided else [])]
    free = np.setdiff1d(np.arange(size), [*held, pulled])
    matrix = csc_array(chain_matrix(joints, bending_n_m2, stretching_n))
    column = matrix[:, [pulled]].toarray().ravel()
    moved = np.zeros(size)
    moved[pulled] = 1.0
    moved[free] = splu(csc_array(matrix[free, :][:, free])).solve(-column[free])
    return float((matrix @ moved)[pulled])


def chain_matrix(joints: FloatArray, bending_n_m2: float, stretching_n: float) -> csc_array:
    """Return the stiffness matrix (3n, 3n) of a chain of beams."""
    rows, columns, values = [], [], []
    for index, (start, end) in enumerate(pairwise(joints)):
        block = beam_matrix(end - start, bending_n_m2, stretching_n)
        dofs = 3 * index + np.arange(6)
        rows.append(np.repeat(dofs, 6))
        columns.append(np.tile(dofs, 6))
        values.append(block.ravel())
    size = 3 * len(joints)
    shape = (np.concatenate(rows), np.concatenate(columns))
    return csc_array((np.concatenate(values), shape), shape=(size, size))


def beam_matrix(along_m: FloatArray, bending_n_m2: float, stretching_n: float) -> FloatArray:
    """Return the stiffness matrix (6, 6) of one beam that reaches ``along_m`` (2,) from its first joint."""
    length = float(np.hypot(*along_m))
    c, s = along_m / length
    stretch = stretching_n / length
    k = bending_n_m2 / length**3
    own = np.zeros((6, 6))
    own[np.ix_([0, 3], [0, 3])] = stretch * np.array([[1.0, -1.0], [-1.0, 1.0]])
    own[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = k * np.array(
        [
            [12.0, 6.0 * length, -12.0, 6.0 * length],
            [6.0 * length, 4.0 * length**2, -6.0 * length, 2.0 * length**2],
            [-12.0, -6.0 * length, 12.0, -6.0 * length],
            [6.0 * length, 2.0 * length**2, -6.0 * length, 4.0 * length**2],
        ]
    )
    turn = np.kron(np.eye(2), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))
    result: FloatArray = turn.T @ own @ turn
    return result
