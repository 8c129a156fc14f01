"""Plane-stress finite elements against closed forms, the elastica's published table, and what any statics must obey."""

from __future__ import annotations

import numpy as np
import pytest
import skfem
from hypothesis import given, settings
from hypothesis import strategies as st
from musclewire_design._elasticity import BodyLoad, solve_large, solve_linear
from musclewire_design._finger.closed_forms import end_loaded_cantilever
from musclewire_design._plane_body import PlaneBody

from musclewire.errors import CallerError, NumericsError

LENGTH, DEPTH, MODULUS = 0.1, 0.01, 2e9


def cantilever(thickness: float, along: int, across: int, ratio: float = 0.0, kind: str = "quads") -> PlaneBody:
    mesh = skfem.MeshQuad.init_tensor(
        np.linspace(0.0, LENGTH, along + 1), np.linspace(-thickness / 2, thickness / 2, across + 1)
    )
    return PlaneBody.of_mesh(mesh if kind == "quads" else mesh.to_meshtri(), DEPTH, MODULUS, ratio)


def tip_load(body: PlaneBody, force_n: float) -> BodyLoad:
    """A shear force spread over the free end as a parabola, the other end held."""
    end = body.nodes_near(x_m=LENGTH)
    height = np.abs(body.nodes_m[end, 1]).max()
    weight = 1.0 - (body.nodes_m[end, 1] / height) ** 2
    forces = np.zeros_like(body.nodes_m)
    forces[end, 1] = force_n * weight / weight.sum()
    return BodyLoad(BodyLoad.held(body.nodes_near(x_m=0.0)), forces)


@pytest.mark.parametrize("kind", ["quads", "triangles"])
def test_a_short_cantilever_bends_and_shears_as_timoshenko_says(kind: str) -> None:
    thickness, force = 0.02, 10.0
    body = cantilever(thickness, 24, 6, 0.3, kind)
    tip = solve_linear(body, tip_load(body, force)).displacement_m[body.nodes_near(x_m=LENGTH), 1].mean()
    bending = force * LENGTH**3 / (3.0 * MODULUS * DEPTH * thickness**3 / 12.0)
    # Cowper's shear coefficient of a rectangle: 10 (1 + nu)/(12 + 11 nu); doi 10.1115/1.3625046.
    shear = force * LENGTH / (10.0 * 1.3 / (12.0 + 3.3) * MODULUS / 2.6 * DEPTH * thickness)
    # The held end may not narrow as Timoshenko's does; that stiffens it by a few thousandths.
    assert tip == pytest.approx(bending + shear, rel=6e-3)
    assert tip > bending * 1.02


def test_a_bent_cantilevers_stress_is_that_of_the_beam_formula() -> None:
    thickness, force = 0.004, 1.0
    body = cantilever(thickness, 60, 4)
    stress = solve_linear(body, tip_load(body, force)).von_mises_pa
    middle = body.nodes_near(x_m=LENGTH / 2, y_m=thickness / 2)
    assert stress[middle] == pytest.approx(6.0 * force * (LENGTH / 2) / (DEPTH * thickness**2), rel=2e-3)


@pytest.mark.parametrize("load", [0.1, 0.5, 1.0, 2.0, 5.0, 10.0])
def test_a_slender_cantilever_bends_far_as_the_elastica(load: float) -> None:
    """By the elliptic integrals, which finger/test_elastica.py holds to the table of Mattiasson 1981."""
    thickness, exact = 0.0005, end_loaded_cantilever(load)
    body = cantilever(thickness, 60, 1)
    force = load * MODULUS * DEPTH * thickness**3 / 12.0 / LENGTH**2
    found = solve_large(body, tip_load(body, force), steps=5)
    tip = found.displacement_m[body.nodes_near(x_m=LENGTH, y_m=0.0)][0] / LENGTH
    assert tip[1] == pytest.approx(exact.deflection, abs=6e-4)
    assert -tip[0] == pytest.approx(exact.shortening, abs=6e-4)


def test_a_body_pulled_evenly_has_the_stress_and_the_narrowing_of_hooke() -> None:
    body = cantilever(0.02, 4, 2, 0.3)
    prescribed_m = BodyLoad.moved(body.nodes_near(x_m=0.0), {0: 0.0}) | BodyLoad.moved(
        body.nodes_near(x_m=LENGTH), {0: 1e-5}
    )
    prescribed_m |= BodyLoad.moved(body.nodes_near(x_m=0.0, y_m=0.0), {1: 0.0})
    found = solve_linear(body, BodyLoad(prescribed_m))
    assert found.von_mises_pa == pytest.approx(np.full(len(body.nodes_m), MODULUS * 1e-4), rel=1e-9)
    top = body.nodes_near(y_m=0.01)
    assert found.displacement_m[top, 1] == pytest.approx(np.full(top.size, -0.3 * 1e-4 * 0.01), rel=1e-9)
    pull_n = MODULUS * 1e-4 * 0.02 * DEPTH
    assert found.reaction_n(body.nodes_near(x_m=LENGTH)) == pytest.approx([pull_n, 0.0])
    assert found.reaction_n(body.nodes_near(x_m=0.0)) == pytest.approx([-pull_n, 0.0])


@settings(max_examples=15)
@given(st.floats(-3.0, 3.0), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_turning_and_shifting_a_body_costs_no_energy_and_no_stress(angle: float, dx: float, dy: float) -> None:
    body = cantilever(0.02, 3, 2, 0.3)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    displacement = body.nodes_m @ turn.T - body.nodes_m + [dx, dy]
    inner = body.inner_forces(displacement)
    assert inner.energy_j == pytest.approx(0.0, abs=1e-12)
    assert np.abs(inner.nodal_n).max() < 1e-5
    assert body.von_mises_pa(displacement).max() < 1.0


def test_forces_are_the_slope_of_the_energy_and_the_tangent_that_of_the_forces() -> None:
    body = cantilever(0.03, 2, 1, 0.3, "triangles")
    random = np.random.default_rng(3)
    at, way = 2e-3 * random.normal(size=(2, *body.nodes_m.shape))
    step = 1e-5
    ahead, behind = body.inner_forces(at + step * way), body.inner_forces(at - step * way)
    here = body.inner_forces(at)
    assert (ahead.energy_j - behind.energy_j) / (2 * step) == pytest.approx(here.nodal_n @ way.ravel(), rel=1e-6)
    slope = (ahead.nodal_n - behind.nodal_n) / (2 * step)
    assert here.tangent @ way.ravel() == pytest.approx(slope, rel=1e-5, abs=1e-6 * np.abs(slope).max())


def test_a_load_or_a_material_that_cannot_be_is_said() -> None:
    with pytest.raises(CallerError, match="prescribed displacements name"):
        solve_linear(cantilever(0.01, 4, 1), BodyLoad({}))
    with pytest.raises(CallerError, match="Poisson"):
        PlaneBody.of_mesh(skfem.MeshQuad(), DEPTH, MODULUS, 0.5)


def test_no_balance_is_an_error_that_says_how_far_it_came() -> None:
    """A bar pushed into nothing: St. Venant-Kirchhoff yields before its length is zero."""
    body = cantilever(0.05, 4, 2, 0.3)
    prescribed_m = BodyLoad.held(body.nodes_near(x_m=0.0)) | BodyLoad.moved(
        body.nodes_near(x_m=LENGTH), {0: -1.5 * LENGTH, 1: 0.0}
    )
    with pytest.raises(NumericsError, match=r"find no balance beyond .* % of the load"):
        solve_large(body, BodyLoad(prescribed_m), steps=2)
