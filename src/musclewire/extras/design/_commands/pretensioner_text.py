"""How a pretensioner reads: as text, and as keys for JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from musclewire.extras.design._commands.check_text import check_json, check_lines, finite

if TYPE_CHECKING:
    from musclewire.extras.design._serpentine.analysis import PretensionerDesign
    from musclewire.extras.design._serpentine.geometry import AvailableRoom

MM, MPA = 1e3, 1e-6


def made_json(made: PretensionerDesign, material: str, room: AvailableRoom | None) -> dict[str, Any]:
    """Return a pretensioner under the keys of the interface; numbers that are not finite become null."""
    geometry, curve, duty = made.geometry, made.curve, made.duty
    return {
        "stiffness_n_per_m": made.stiffness_n_per_m,
        "stiffness_guided_n_per_m": made.guided.stiffness_n_per_m,
        "stress_max_pa": finite(made.stress_pa),
        "stress_allowable_pa": made.material.allowable_stress_pa.value,
        "stress_yield_pa": made.material.yield_stress_pa.value,
        "pretension_n": duty.pretension_n,
        "travel_m": made.travel_m,
        "safe_travel_m": curve.safe_travel_m,
        "finger_share": finger_share(made),
        "geometry": {
            "beams": geometry.beams,
            "half_length_m": geometry.half_length_m,
            "pitch_m": geometry.pitch_m,
            "thickness_m": geometry.thickness_m,
            "depth_m": geometry.depth_m,
            "corner_radius_m": geometry.corner_radius_m,
            "across_m": geometry.across_m,
            "along_m": geometry.along_m,
        },
        "envelope_m": None if room is None else list(room),
        "material": material,
        "process": made.process,
        "mass_kg": made.mass_kg,
        "curve": {
            "travel_m": curve.travel_m.tolist(),
            "force_n": curve.force_n.tolist(),
            "stress_pa": curve.stress_pa.tolist(),
        },
        "checks": [check_json(check) for check in made.checks],
        "holds": made.holds,
    }


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


def materials_json() -> dict[str, Any]:
    """Return all included materials."""
    from musclewire.parameters import load_material, material_names

    return {
        "materials": [
            {
                "name": name,
                **load_material(name).values(),
                "minimum_thickness_m": {key: it.value for key, it in load_material(name).minimum_thickness_m.items()},
            }
            for name in material_names()
        ]
    }


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
