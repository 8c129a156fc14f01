"""A flat elastic body cut into finite elements: positions of its nodes, and the energy it stores when they move.

Total Lagrangian, St. Venant-Kirchhoff, plane stress: with the Green-Lagrange strain E = (F'F - 1)/2 of the in-plane
deformation gradient F, the energy density is 1/2 E:C:E with Hooke's plane-stress matrix C. Exact for any rotation, good
for the small strains at which flexures work. Bonet and Wood 2008, Nonlinear Continuum Mechanics for Finite Element
Analysis, sections 6.5 and 9.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from musclewire.arrays import FloatArray, IntArray
from musclewire.errors import CallerError

# Gauss rules that integrate the stiffness of undistorted quadratic elements exactly.
QUADRATURE_ORDER = 4


@dataclass(frozen=True)
class InnerForces:
    """Response of a deformed body: its energy [J], the force that holds each node (n_dofs,) [N], its tangent [N/m].

    The tangent, most of the work, is computed when it is asked for.
    """

    energy_j: float
    nodal_n: FloatArray
    turned_inside_out: bool
    _tangent: Callable[[], csr_array]

    @cached_property
    def tangent(self) -> csr_array:
        """Change of the nodal forces over displacement [N/m], (n_dofs, n_dofs)."""
        return self._tangent()


@dataclass(frozen=True)
class PlaneBody:
    """A body of constant depth in plane stress, with quadratic elements.

    ``nodes_m`` (n_nodes, 2) holds all nodes, those on the middle of sides and elements too; select some by position.
    Degree of freedom ``2 * node + axis`` is the displacement of a node along x (0) or y (1).

    ``elements`` (n_elements, n_local), ``gradients_per_m`` (n_elements, n_points, n_local, 2) and ``volumes_m3``
    (n_elements, n_points) describe shape functions at Gauss points.
    """

    mesh: Any
    basis: Any
    nodes_m: FloatArray
    elements: IntArray
    gradients_per_m: FloatArray
    volumes_m3: FloatArray
    youngs_modulus_pa: float
    poisson_ratio: float

    @classmethod
    def of_mesh(cls, mesh: Any, depth_m: float, youngs_modulus_pa: float, poisson_ratio: float) -> PlaneBody:
        """Make a body from a scikit-fem mesh of quadrilaterals or triangles [m].

        Raises CallerError for another kind of mesh, or an impossible depth, modulus or Poisson's ratio.
        """
        import skfem

        kinds = {"MeshQuad1": skfem.ElementQuad2, "MeshQuad2": skfem.ElementQuad2}
        kinds |= {"MeshTri1": skfem.ElementTriP2, "MeshTri2": skfem.ElementTriP2}
        kind = kinds.get(type(mesh).__name__)
        if kind is None:
            raise CallerError(f"a plane body requires a mesh of quadrilaterals or triangles, not {type(mesh).__name__}")
        if not (depth_m > 0.0 and youngs_modulus_pa > 0.0 and 0.0 <= poisson_ratio < 0.5):
            raise CallerError(
                f"depth {depth_m:g} m and Young's modulus {youngs_modulus_pa:g} Pa must be above 0, Poisson's ratio "
                f"{poisson_ratio:g} from 0 to below 0.5"
            )
        basis = skfem.Basis(mesh, kind(), intorder=QUADRATURE_ORDER)
        shapes = [np.asarray(shape[0].grad) for shape in basis.basis]  # each (2, n_elements, n_points)
        return cls(
            mesh=mesh,
            basis=basis,
            nodes_m=np.ascontiguousarray(basis.doflocs.T),
            elements=np.ascontiguousarray(basis.element_dofs.T.astype(np.int64)),
            gradients_per_m=np.ascontiguousarray(np.stack(shapes, axis=-1).transpose(1, 2, 3, 0)),
            volumes_m3=np.asarray(basis.dx) * depth_m,
            youngs_modulus_pa=youngs_modulus_pa,
            poisson_ratio=poisson_ratio,
        )

    @property
    def n_dofs(self) -> int:
        """Number of degrees of freedom."""
        return 2 * len(self.nodes_m)

    def nodes_near(self, x_m: float | None = None, y_m: float | None = None, within_m: float = 1e-9) -> IntArray:
        """Return the nodes with this x, this y, or both."""
        chosen = np.ones(len(self.nodes_m), dtype=bool)
        for axis, place in enumerate((x_m, y_m)):
            if place is not None:
                chosen &= np.abs(self.nodes_m[:, axis] - place) <= within_m
        return np.flatnonzero(chosen)

    def hooke_pa(self) -> FloatArray:
        """Return Hooke's matrix for plane stress (3, 3), for strains xx, yy and twice xy."""
        ratio = self.poisson_ratio
        shape = [[1.0, ratio, 0.0], [ratio, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - ratio)]]
        return self.youngs_modulus_pa / (1.0 - ratio**2) * np.array(shape)

    def deformation_gradients(self, displacement_m: FloatArray) -> FloatArray:
        """Return F (n_elements, n_points, 2, 2) for displacements (n_nodes, 2)."""
        moved = displacement_m[self.elements]
        gradient: FloatArray = np.eye(2) + np.einsum("eai,eqaj->eqij", moved, self.gradients_per_m, optimize=True)
        return gradient

    def second_stress_pa(self, gradient: FloatArray) -> FloatArray:
        """Return the second Piola-Kirchhoff stress (..., 3) as xx, yy, xy for deformation gradients (..., 2, 2)."""
        strain = green_lagrange(gradient)
        voigt = np.stack([strain[..., 0, 0], strain[..., 1, 1], 2.0 * strain[..., 0, 1]], axis=-1)
        return voigt @ self.hooke_pa()

    def inner_forces(self, displacement_m: FloatArray) -> InnerForces:
        """Return energy, nodal forces (n_dofs,) and tangent of the body with displacements (n_nodes, 2)."""
        gradient = self.deformation_gradients(displacement_m)
        stress = self.second_stress_pa(gradient)
        strain_rate = self._strain_per_displacement(gradient)
        weight = self.volumes_m3[..., None]
        forces = np.einsum("eqk,eqkd->ed", stress * weight, strain_rate, optimize=True)
        inside_out = bool((np.linalg.det(gradient) <= 0.0).any())
        return InnerForces(
            self._energy_j(gradient, stress),
            self._gathered(forces),
            inside_out,
            lambda: self._assembled(self._element_tangents(stress, strain_rate)),
        )

    def _element_tangents(self, stress: FloatArray, strain_rate: FloatArray) -> FloatArray:
        """Return the tangent of each element (n_elements, 2 * n_local, 2 * n_local)."""
        weighted = np.sqrt(self.volumes_m3[..., None, None]) * strain_rate
        n_elements, _, _, n_local = weighted.shape
        flat = weighted.reshape(n_elements, -1, n_local)
        stiff = np.matmul(self.hooke_pa(), weighted).reshape(n_elements, -1, n_local)
        tangents: FloatArray = np.swapaxes(flat, 1, 2) @ stiff + self._stress_tangent(stress)
        return tangents

    def _energy_j(self, gradient: FloatArray, stress: FloatArray) -> float:
        strain = green_lagrange(gradient)
        density = stress[..., 0] * strain[..., 0, 0] + stress[..., 1] * strain[..., 1, 1]
        density = 0.5 * density + stress[..., 2] * strain[..., 0, 1]
        return float((density * self.volumes_m3).sum())

    def _strain_per_displacement(self, gradient: FloatArray) -> FloatArray:
        """Return how strain (xx, yy, twice xy) changes with each element's displacements (..., 3, 2 * n_local)."""
        slope = self.gradients_per_m
        along_x, along_y = slope[..., 0, None], slope[..., 1, None]
        column_x, column_y = gradient[..., None, :, 0], gradient[..., None, :, 1]
        rows = [along_x * column_x, along_y * column_y, along_x * column_y + along_y * column_x]
        n_elements, n_points, n_local, _ = slope.shape
        return np.stack([row.reshape(n_elements, n_points, 2 * n_local) for row in rows], axis=-2)

    def _stress_tangent(self, stress: FloatArray) -> FloatArray:
        """Return the geometric stiffness of each element, which stress adds to its tangent by turning with the body."""
        matrix = stress[..., [0, 2, 2, 1]].reshape(*stress.shape[:-1], 2, 2) * self.volumes_m3[..., None, None]
        pulled = np.matmul(self.gradients_per_m, matrix)
        scalar = np.einsum("eqai,eqbi->eab", pulled, self.gradients_per_m, optimize=True)
        n_elements, n_local, _ = scalar.shape
        whole = np.zeros((n_elements, n_local, 2, n_local, 2))
        whole[:, :, 0, :, 0] = whole[:, :, 1, :, 1] = scalar
        return whole.reshape(n_elements, 2 * n_local, 2 * n_local)

    def _element_dofs(self) -> IntArray:
        return (2 * self.elements[..., None] + np.arange(2)).reshape(len(self.elements), -1)

    def _gathered(self, forces: FloatArray) -> FloatArray:
        dofs = self._element_dofs().ravel()
        return np.bincount(dofs, weights=forces.ravel(), minlength=self.n_dofs).astype(np.float64)

    def _assembled(self, matrices: FloatArray) -> csr_array:
        dofs = self._element_dofs()
        rows = np.repeat(dofs, dofs.shape[1], axis=1).ravel()
        columns = np.tile(dofs, (1, dofs.shape[1])).ravel()
        return csr_array((matrices.ravel(), (rows, columns)), shape=(self.n_dofs, self.n_dofs))

    def von_mises_pa(self, displacement_m: FloatArray) -> FloatArray:
        """Return von Mises' stress (n_elements, n_points) of the true (Cauchy) stress at the Gauss points."""
        gradient = self.deformation_gradients(displacement_m)
        second = self.second_stress_pa(gradient)
        matrix = second[..., [0, 2, 2, 1]].reshape(*second.shape[:-1], 2, 2)
        # The depth's own change under stress is of the order of the strain and is left out.
        true = gradient @ matrix @ np.swapaxes(gradient, -1, -2) / np.linalg.det(gradient)[..., None, None]
        return von_mises(true[..., 0, 0], true[..., 1, 1], true[..., 0, 1])

    def von_mises_small_pa(self, displacement_m: FloatArray) -> FloatArray:
        """Return von Mises' stress (n_elements, n_points) by the linear theory of small displacements."""
        slope = self.deformation_gradients(displacement_m) - np.eye(2)
        strain = np.stack([slope[..., 0, 0], slope[..., 1, 1], slope[..., 0, 1] + slope[..., 1, 0]], axis=-1)
        stress = strain @ self.hooke_pa()
        return von_mises(stress[..., 0], stress[..., 1], stress[..., 2])

    def at_nodes(self, at_points: FloatArray) -> FloatArray:
        """Extrapolate values at Gauss points (n_elements, n_points) to the nodes (n_nodes,).

        Each element's values are fitted by a plane (which also reaches its surface, where no Gauss point is) or, with
        nine points or more, a quadratic; nodes that elements share get the average.
        """
        points = np.asarray(self.basis.global_coordinates()).transpose(1, 2, 0)
        corners = self.nodes_m[self.elements]
        centre = corners.mean(axis=1, keepdims=True)
        size = np.abs(corners - centre).max(axis=(1, 2), keepdims=True)
        fit = np.linalg.pinv(monomials((points - centre) / size, points.shape[1]))
        values = monomials((corners - centre) / size, points.shape[1]) @ (fit @ at_points[..., None])
        count = np.bincount(self.elements.ravel(), minlength=len(self.nodes_m))
        total = np.bincount(self.elements.ravel(), weights=values.ravel(), minlength=len(self.nodes_m))
        return total / count


def green_lagrange(gradient: FloatArray) -> FloatArray:
    """Return the strain (F'F - 1)/2 of deformation gradients (..., 2, 2)."""
    strain: FloatArray = 0.5 * (np.swapaxes(gradient, -1, -2) @ gradient - np.eye(2))
    return strain


def von_mises(xx: FloatArray, yy: FloatArray, xy: FloatArray) -> FloatArray:
    """Return von Mises' equivalent of a plane stress."""
    equivalent: FloatArray = np.sqrt(xx**2 - xx * yy + yy**2 + 3.0 * xy**2)
    return equivalent


def monomials(places: FloatArray, n_points: int) -> FloatArray:
    """Return 1, x, y and, if there are enough points to fit them, x^2, x y, y^2 at places (..., 2)."""
    x, y = places[..., 0], places[..., 1]
    parts = [np.ones_like(x), x, y]
    return np.stack([*parts, x * x, x * y, y * y] if n_points >= 9 else parts, axis=-1)
