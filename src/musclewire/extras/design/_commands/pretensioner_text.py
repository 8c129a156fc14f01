"""How a pretensioner reads: as text, and as keys for JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from musclewire.extras.design._commands.check_text import check_lines

if TYPE_CHECKING:
    from musclewire.extras.design._answers import MaterialsAnswer, PretensionerAnswer
    from musclewire.extras.design._serpentine.analysis import PretensionerDesign
    from musclewire.extras.design._serpentine.geometry import AvailableRoom

MM, MPA = 1e3, 1e-6


def made_answer(made: PretensionerDesign, material: str, room: AvailableRoom | None) -> PretensionerAnswer:
    """Return a pretensioner under the keys of the interface."""
    from musclewire.extras.design._answers import PretensionerAnswer

    return PretensionerAnswer.read_from(
        made,
        stiffness_guided_n_per_m=made.guided.stiffness_n_per_m,
        stress_max_pa=made.stress_pa,
        stress_allowable_pa=made.material.allowable_stress_pa.value,
        stress_yield_pa=made.material.yield_stress_pa.value,
        pretension_n=made.duty.pretension_n,
        safe_travel_m=made.curve.safe_travel_m,
        finger_share=finger_share(made),
        envelope_m=room,
        material=material,
    )


def finger_share(made: PretensionerDesign) -> float | None:
    """Return the fraction of the contraction force that the finger gets, k_f/(k_p + k_f); None without a finger."""
    finger = made.duty.finger_stiffness_n_per_m
    return None if finger is None else finger / (finger + made.stiffness_n_per_m)


def made_text(made: PretensionerDesign, room: AvailableRoom | None) -> str:
    """Return a pretensioner as lines for people."""
    g, curve = made.geometry, made.curve
    sizes = " x ".join(f"{MM * size:.2f}" for size in (g.across_m, g.along_m, g.depth_m))
    rooms = "" if room is None else f"; there are {' x '.join(f'{MM * size:g}' for size in room)} mm"
    lines = [
        f"serpentine pretensioner of {made.material.name} ({made.process})",
        f"  dimensions  {g.beams} beams, half length {MM * g.half_length_m:.2f} mm, pitch {MM * g.pitch_m:.2f} mm, "
        f"{MM * g.thickness_m:.2f} mm thick, {MM * g.depth_m:.2f} mm deep, corners of {MM * g.corner_radius_m:.2f} mm",
        f"  size        {sizes} mm across the wire, along it, out of plane{rooms}",
        f"  stiffness   {made.stiffness_n_per_m:.1f} N/m; {made.guided.stiffness_n_per_m:.1f} N/m if the connector can "
        "neither turn nor move aside",
    ]
    lines += duty_lines(made)
    lines.append(
        f"  safe        to {MM * curve.safe_travel_m:.2f} mm of travel, {curve.force_at(curve.safe_travel_m):.2f} N"
    )
    fraction = finger_share(made)
    if fraction is not None:
        lines.append(
            f"  finger      {100 * fraction:.0f} % of the contraction force goes to a finger of "
            f"{made.duty.finger_stiffness_n_per_m:g} N/m"
        )
    return "\n".join([*lines, "", *check_lines(made.checks)])


def duty_lines(made: PretensionerDesign) -> list[str]:
    """Return the lines of travel and stress."""
    if made.travel_m is None or made.stress_pa is None:
        return []
    duty, material = made.duty, made.material
    parts = ""
    if duty.travel_m is None and duty.pretension_n is not None:
        parts = (
            f": {MM * (made.travel_m - duty.stroke_m):.2f} mm for {duty.pretension_n:g} N of pretension, "
            f"{MM * duty.stroke_m:.2f} mm with the wire"
        )
    return [
        f"  travel      {MM * made.travel_m:.2f} mm{parts}",
        f"  stress      {MPA * made.stress_pa:.1f} MPa there, a strain of "
        f"{100 * made.stress_pa / material.youngs_modulus_pa.value:.2g} %; "
        f"{MPA * material.allowable_stress_pa.value:g} MPa are allowed for long, "
        f"{MPA * material.yield_stress_pa.value:g} MPa are the yield stress",
    ]


def materials_answer() -> MaterialsAnswer:
    """Return all included materials."""
    from musclewire.extras.design._answers import IncludedMaterial, MaterialsAnswer
    from musclewire.parameters import load_material, material_names

    found = []
    for name in material_names():
        material = load_material(name)
        thinnest_m = {process: thickness.value for process, thickness in material.minimum_thickness_m.items()}
        found.append(IncludedMaterial(name=name, minimum_thickness_m=thinnest_m, **material.values()))
    return MaterialsAnswer(materials=tuple(found))


def materials_text() -> str:
    """Return all included materials as a table."""
    from musclewire.parameters import load_material, material_names

    lines = [f"{'material':<16}{'modulus':>10}{'yield':>10}{'allowed':>10}   thinnest by process"]
    for name in material_names():
        material = load_material(name)
        processes = ", ".join(f"{key} {MM * it.value:g} mm" for key, it in material.minimum_thickness_m.items())
        lines.append(
            f"{name:<16}{1e-9 * material.youngs_modulus_pa.value:>6.4g} GPa"
            f"{MPA * material.yield_stress_pa.value:>6.4g} MPa{MPA * material.allowable_stress_pa.value:>6.4g} MPa"
            f"   {processes}"
        )
    return "\n".join(lines)
