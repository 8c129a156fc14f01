"""The page reference/toml_files of the site, from the schemas that check models, and TOML files but those of rigs."""

from __future__ import annotations

from key_tables import default_of, meanings, section, type_in_words
from pydantic import BaseModel

from musclewire.controllers import (
    ConstantRules,
    FeedforwardSettings,
    FuzzyPidSettings,
    MamdaniRules,
    MembershipSet,
    RuleBase,
    ZhaoRules,
)
from musclewire.extras.studies import ParameterTable, Sampling, StudyFile
from musclewire.parameters import (
    FileGeometry,
    FingerCurve,
    FingerFile,
    Material,
    Parameter,
    PretensionerFile,
    Prior,
    PriorSet,
    WireFile,
)
from musclewire.sensing import ModelFile

HEAD = """# Files, key by key

For those who write such a file or look up a key of one; [rig files](rig_files.md) have a page of their own. Numbers are
in SI unless a column says otherwise, and an unknown key is an error that names the nearest.
"""
# What is said of keys that their schemas' docstrings leave to their names.
SAID = {
    "format": "what the file is; what writes one writes it",
    "version": "version of the format, 1",
    "name": "a name for reports",
    "description": "a sentence for reports",
    "wire": "a number with its source for each of the wire's own parameters",
    "alloy": "the same for those of its alloy",
    "bench": "the same for those of the bench that it was calibrated on",
    "material": "name or file of the material",
    "process": "how it is made: a key of the material's `minimum_thickness_m`",
    "geometry": "its dimensions",
    "computed": "what follows from them, each number with its source; not read by the rig",
    "beams": "how many beams fold to and fro",
    "half_length_m": "half the length of a beam",
    "pitch_m": "distance between the centre lines of two beams",
    "thickness_m": "thickness of a beam, in the plane",
    "depth_m": "thickness of the sheet",
    "corner_radius_m": "radius of the turns between beams",
    "density_kg_per_m3": "density",
    "shape": "triangle, z (falls from 1 to 0) or s (rises from 0 to 1)",
    "points": "where it begins, peaks and ends, on the universe -3..3; two points for z and s",
    "inference": "how rules are combined, as here",
    "kp": "of K_p: a label for each pair of error and its rate; with constant rules a ratio between 0 and 1",
    "ki": "of K_I, the same",
    "kd": "of K_D, the same",
    "alpha": "of the ratio of integral to derivative time, between 2 and 5",
    "output_sets": "the seven membership functions of the outputs by name",
}
SECTIONS: dict[str, tuple[type[BaseModel], str]] = {
    "A number with its source": (
        Parameter,
        "What is at most keys of wires, alloys, benches, fingers and materials; their names, units and values are in "
        "[parameters, one by one](parameters.md).",
    ),
    "Model file": (ModelFile, "JSON, written by `musclewire fit`: [files](files.md#models-json)."),
    "Wire file": (WireFile, "Written by `musclewire calibrate`: [how to](../how-to/calibrate_my_wire.md)."),
    "Study": (StudyFile, "Read by `musclewire sweep`: [how to](../how-to/run_a_study_of_many_wires.md)."),
    "`[sampling]` of a study": (Sampling, ""),
    "`[parameters.NAME]` of a study": (ParameterTable, ""),
    "Priors": (PriorSet, "What is known of a wire before it is calibrated: `musclewire calibrate --priors`."),
    "`[parameters.NAME]` of priors": (Prior, ""),
    "Finger": (FingerFile, "Written by `musclewire design finger`: [how to](../how-to/design_a_finger.md)."),
    "`[curve]` of a finger": (FingerCurve, ""),
    "Pretensioner": (
        PretensionerFile,
        "Written by `musclewire design pretensioner`: [how to](../how-to/design_a_finger.md).",
    ),
    "`[geometry]` of a pretensioner": (FileGeometry, ""),
    "Material": (Material, "What flexures are made of: `--material` of both `design` commands takes its file."),
    "`[settings]` of gains for `fuzzy-pid`": (
        FuzzyPidSettings,
        "A gains file has `format`, `controller` and `[settings]`; written by `musclewire tune`: "
        "[how to](../how-to/tune_a_controller.md).",
    ),
    "`[settings]` of gains for `inverse-model`": (FeedforwardSettings, ""),
    "Rule base": (RuleBase, "How to write one: [rule bases and gains](rules.md)."),
    "`[input_sets]` and `[output_sets]` of a rule base": (MembershipSet, ""),
    '`[rules]` with `inference = "product-weighted-sum"`': (ZhaoRules, ""),
    '`[rules]` with `inference = "min-max-centroid"`': (MamdaniRules, ""),
    '`[rules]` with `inference = "constant"`': (ConstantRules, ""),
}


def page() -> str:
    """Return the whole page."""
    sections = [keys_section(title, model, text) for title, (model, text) in SECTIONS.items()]
    return "\n".join([HEAD, *sections])


def keys_section(title: str, model: type[BaseModel], text: str) -> str:
    """Return the table of a file's keys, or of a table in it."""
    said = {**SAID, **meanings(model)}
    rows = []
    for name, field in model.model_fields.items():
        meaning = said.get(name) or field.description or type_in_words(field)
        choices = type_in_words(field) if name in ("kind", "shape", "inference") else ""
        rows.append((f"`{name}`", default_of(field) or "empty", (choices or meaning).replace("|", "\\|")))
    return section(title, text, ("File key", "Default", "Meaning"), rows)
