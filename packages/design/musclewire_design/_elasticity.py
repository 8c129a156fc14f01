"""Statics of flat elastic bodies at small and large displacements: displacements, forces, stresses.

Nodes are moved by prescribed displacements in as many load steps as needed, each brought to balance by Newton's method.
Forces may act on nodes, and anything else with a potential energy (a tendon, a contact) can be added as a function of
the displacements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from scipy.sparse import csc_array, csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from musclewire.arrays import FloatArray, IntArray
from musclewire.errors import CallerError, NumericsError
from musclewire_design._plane_body import PlaneBody

# Forces are in balance if the residual is this fraction of the largest force in the body, or if the last correction
# moved no node by more than this fraction of the body's size: under tiny loads only rounding remains.
BALANCE, STILL = 1e-8, 1e-10
MAX_ITERATIONS = 15
MAX_HALVINGS = 10


class PotentialChange(NamedTuple):
    """Energy [J] of something outside the body, its gradient (n_dofs,) [N] and Hessian (n_dofs, n_dofs) [N/m]."""

    energy_j: float
    gradient_n: FloatArray
    hessian: csr_array


class ExternalPotential(Protocol):
    """Something outside the body whose energy depends on the positions of the nodes."""

    def __call__(self, displacement_m: FloatArray, load_fraction: float) -> PotentialChange:
        """Return energy, gradient and Hessian at displacements (n_nodes, 2) and a fraction of the load, 0 to 1."""


@dataclass(frozen=True)
class BodyLoad:
    """Load of a body: prescribed displacements [m] by degree of freedom, forces (n_nodes, 2) [N], a potential."""

    prescribed_m: Mapping[int, float]
    forces_n: FloatArray | None = None
    potential: ExternalPotential | None = None

    @staticmethod
    def held(nodes: IntArray, axes: tuple[int, ...] = (0, 1)) -> dict[int, float]:
        """Return prescribed displacements that hold nodes still along these axes."""
        return BodyLoad.moved(nodes, dict.fromkeys(axes, 0.0))

    @staticmethod
    def moved(nodes: IntArray, by_m: Mapping[int, float]) -> dict[int, float]:
        """Return prescribed displacements of nodes, by axis."""
        return {2 * int(node) + axis: by for node in np.atleast_1d(nodes) for axis, by in by_m.items()}


@dataclass(frozen=True)
class BodyEquilibrium:
    """A body in balance: displacements (n_nodes, 2), fraction of the load, and external forces (n_nodes, 2).

    ``holding_n`` is the external force on each node: the reaction where a displacement is
    prescribed, the given force elsewhere.
    """

    body: PlaneBody
    displacement_m: FloatArray
    holding_n: FloatArray
    load_fraction: float = 1.0
    linear: bool = False

    def reaction_n(self, nodes: IntArray) -> FloatArray:
        """Return the force (2,) on these nodes together."""
        force: FloatArray = self.holding_n[np.atleast_1d(nodes)].sum(axis=0)
        return force

    @cached_property
    def von_mises_pa(self) -> FloatArray:
        """Von Mises' stress (n_nodes,), extrapolated from Gauss points and averaged at nodes."""
        at_points = self.body.von_mises_small_pa if self.linear else self.body.von_mises_pa
        nodal: FloatArray = np.maximum(self.body.at_nodes(at_points(self.displacement_m)), 0.0)
        return nodal


def solve_linear(body: PlaneBody, load: BodyLoad) -> BodyEquilibrium:
    """Return the balance for small displacements; a potential is not allowed here (it is nonlinear).

    Raises CallerError for a load that does not fit the body or leaves it free to move.
    """
    if load.potential is not None:
        raise CallerError("a potential needs solve_large: small displacements have no potential")
    start = np.zeros_like(body.nodes_m)
    problem = ElasticityProblem(body, load)
    tangent = body.inner_forces(start).tangent
    moves = problem.step(tangent, problem.given_forces(1.0), problem.prescribed_values(1.0))
    displacement = moves.reshape(-1, 2)
    return BodyEquilibrium(body, displacement, (tangent @ moves).reshape(-1, 2), linear=True)


def solve_large(body: PlaneBody, load: BodyLoad, steps: int = 4) -> BodyEquilibrium:
    """Return the balance under the whole load, at displacements of any size.

    Raises NumericsError if it cannot be found; the message states the fraction of the load and what to do.
    """
    if steps < 1:
        raise CallerError(f"a load is applied in one step at least, not {steps}")
    return list(load_path(body, load, np.linspace(0.0, 1.0, steps + 1)[1:]))[-1]


def load_path(
    body: PlaneBody, load: BodyLoad, load_fractions: FloatArray, stop: Callable[[BodyEquilibrium], bool] | None = None
) -> Iterator[BodyEquilibrium]:
    """Yield the balance at each fraction of the load; a step that does not converge is halved, up to ten times.

    Ends early after the first balance for which ``stop`` holds. Fractions may exceed 1.
    """
    problem = ElasticityProblem(body, load)
    displacement, reached = np.zeros_like(body.nodes_m), 0.0
    speed = np.zeros_like(displacement)
    for load_fraction in np.asarray(load_fractions, dtype=np.float64):
        # The motion of the last step is a good guess for the next.
        guess = displacement + (load_fraction - reached) * speed
        found = problem.balance(guess, float(load_fraction)) if speed.any() else None
        if found is None:
            found = problem.walk(displacement, reached, float(load_fraction))
        speed = (found - displacement) / (load_fraction - reached) if load_fraction != reached else speed
        displacement, reached = found, float(load_fraction)
        forces = body.inner_forces(displacement).nodal_n + problem.pull(displacement, reached)[0]
        state = BodyEquilibrium(body, displacement, forces.reshape(-1, 2), reached)
        yield state
        if stop is not None and stop(state):
            return


class ElasticityProblem:
    """A body with its load: its free unknowns, and Newton's method for them."""

    def __init__(self, body: PlaneBody, load: BodyLoad) -> None:
        """Sort the unknowns. Raises CallerError for a load that does not fit the body."""
        self.body, self.load = body, load
        self.prescribed = np.array(sorted(load.prescribed_m), dtype=np.int64)
        if self.prescribed.size == 0 or self.prescribed[0] < 0 or self.prescribed[-1] >= body.n_dofs:
            raise CallerError(f"prescribed displacements name degrees of freedom from 0 to {body.n_dofs - 1}")
        if load.forces_n is not None and np.shape(load.forces_n) != body.nodes_m.shape:
            raise CallerError(
                f"forces have the shape {np.shape(load.forces_n)}, nodes {body.nodes_m.shape}: give one force a node"
            )
        self.values = np.array([load.prescribed_m[int(dof)] for dof in self.prescribed])
        self.free = np.setdiff1d(np.arange(body.n_dofs), self.prescribed)
        # Found with the first tangent: all tangents of a problem have the same pattern.
        self._order: IntArray | None = None

    def prescribed_values(self, load_fraction: float) -> FloatArray:
        """Return the prescribed displacements at a fraction of the load."""
        return load_fraction * self.values

    def given_forces(self, load_fraction: float) -> FloatArray:
        """Return the given forces (n_dofs,) at a fraction of the load."""
        given = self.load.forces_n
        return np.zeros(self.body.n_dofs) if given is None else load_fraction * np.asarray(given, dtype=float).ravel()

    def pull(self, displacement: FloatArray, load_fraction: float) -> tuple[FloatArray, csr_array | None]:
        """Return gradient and Hessian of the potential."""
        if self.load.potential is None:
            return np.zeros(self.body.n_dofs), None
        change = self.load.potential(displacement, load_fraction)
        return change.gradient_n, change.hessian

    def step(self, tangent: csr_array, residual: FloatArray, prescribed_m: FloatArray) -> FloatArray:
        """Return the change of all displacements (n_dofs,) for a residual and prescribed changes."""
        moves = np.zeros(self.body.n_dofs)
        moves[self.prescribed] = prescribed_m
        order = self.order_of(tangent)
        right = residual[order] - (tangent @ moves)[order]
        matrix = csc_array(csc_array(tangent)[:, order][order, :])
        try:
            moves[order] = splu(matrix, permc_spec="NATURAL").solve(right)
        except RuntimeError:
            raise CallerError("the body is free to move: hold more of its nodes") from None
        return moves

    def order_of(self, tangent: csr_array) -> IntArray:
        """Return the free unknowns in an order along the body, in which a slender one's factors stay narrow."""
        if self._order is None:
            inner = csr_array(csc_array(tangent)[:, self.free][self.free, :])
            self._order = self.free[reverse_cuthill_mckee(inner, symmetric_mode=True)]
        return self._order

    def walk(self, displacement: FloatArray, start: float, end: float) -> FloatArray:
        """Return the displacements at the fraction ``end``, from balance at ``start``; halves a step that fails."""
        at, stride = start, end - start
        while at != end:
            target = end if abs(end - at) <= abs(stride) * (1.0 + 1e-12) else at + stride
            found = self.balance(displacement, target)
            if found is not None:
                displacement, at = found, target
            elif abs(stride) <= abs(end - start) / 2**MAX_HALVINGS:
                raise NumericsError(
                    f"the finite elements find no balance beyond {100 * at:.3g} % of the load: ask for less travel "
                    "or force, or look for a snap-through"
                )
            else:
                stride *= 0.5
        return displacement

    def balance(self, displacement: FloatArray, load_fraction: float) -> FloatArray | None:
        """Return balanced displacements at a fraction of the load by Newton's method; None if it diverges."""
        given = self.given_forces(load_fraction)
        still_m = STILL * float(np.ptp(self.body.nodes_m, axis=0).max())
        moved_m = np.inf
        moves_m = self.prescribed_values(load_fraction) - displacement.ravel()[self.prescribed]
        for _ in range(MAX_ITERATIONS):
            inner = self.body.inner_forces(displacement)
            pulled, hessian = self.pull(displacement, load_fraction)
            residual = given - inner.nodal_n - pulled
            scale = max(np.abs(inner.nodal_n).max(), np.abs(given).max(), np.abs(pulled).max())
            if not np.isfinite(scale) or inner.turned_inside_out:
                return None
            left_n = np.abs(residual[self.free]).max(initial=0.0)
            if not moves_m.any() and (left_n <= BALANCE * scale or moved_m <= still_m):
                return displacement
            tangent = inner.tangent if hessian is None else csr_array(inner.tangent + hessian)
            change = self.step(tangent, residual, moves_m)
            displacement, moved_m = displacement + change.reshape(-1, 2), float(np.abs(change).max())
            moves_m = np.zeros_like(moves_m)
        return None
