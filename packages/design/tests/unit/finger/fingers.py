"""Fingers that several tests bend."""

from __future__ import annotations

from musclewire_design._finger.geometry import FingerGeometry

PLAIN = FingerGeometry(
    overall_length_m=0.010,
    plate_length_m=0.005,
    columns=4,
    column_width_m=0.3e-3,
    column_height_m=2.2e-3,
    tendon_offset_m=1.1e-3,
    beam_thickness_m=0.18e-3,
    beam_depth_m=5e-3,
    inward_angle_rad=0.0,
    plate_thickness_m=0.9e-3,
    youngs_modulus_pa=2.6e9,
)
CURVED = PLAIN.with_(inward_angle_rad=0.2)
