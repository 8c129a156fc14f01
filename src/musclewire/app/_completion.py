"""What a shell may put in place of a name that is begun: the names that ship with musclewire, and the user's own files.

The shell asks `musclewire` itself, so that nothing here can differ from what the commands take. Each function gets what
was typed so far; what it needs is imported when a shell asks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path


def complete_rigs(incomplete: str) -> list[str]:
    """Return the included rigs and the TOML files that begin so."""
    from musclewire.rigs import rig_names

    return beginning(rig_names(), incomplete) + toml_files(incomplete)


def complete_wires(incomplete: str) -> list[str]:
    """Return the wires of the library and the catalogue, and the TOML files that begin so."""
    from musclewire.parameters import names

    return beginning(names("wire"), incomplete) + toml_files(incomplete)


def complete_materials(incomplete: str) -> list[str]:
    """Return the materials of the library, and the TOML files that begin so."""
    from musclewire.parameters import material_names

    return beginning(material_names(), incomplete) + toml_files(incomplete)


def complete_fingers(incomplete: str) -> list[str]:
    """Return the fingers of the library, and the TOML files that begin so."""
    from musclewire.parameters import finger_names

    return beginning(finger_names(), incomplete) + toml_files(incomplete)


def complete_rule_bases(incomplete: str) -> list[str]:
    """Return the rule bases that begin so."""
    from musclewire.controllers import rule_base_names

    return beginning(rule_base_names(), incomplete)


def complete_estimators(incomplete: str) -> list[str]:
    """Return the estimators that begin so, those of other packages included."""
    from musclewire.sensing import ESTIMATORS

    return beginning(ESTIMATORS.names(), incomplete)


def complete_controllers(incomplete: str) -> list[str]:
    """Return the controllers that begin so, those of other packages included."""
    from musclewire.controllers import CONTROLLERS

    return beginning(CONTROLLERS.names(), incomplete)


def completion_of(*names: str) -> Callable[[str], list[str]]:
    """Return what completes an option that takes no other names than these."""
    return lambda incomplete: beginning(names, incomplete)


def complete_schemas(incomplete: str) -> list[str]:
    """Return the names of JSON Schemas that begin so."""
    from musclewire.app._json_schemas import schema_names

    return beginning(schema_names(), incomplete)


def beginning(names: Iterable[str], incomplete: str) -> list[str]:
    """Return the names that begin as what was typed."""
    return [name for name in names if name.startswith(incomplete)]


def toml_files(incomplete: str) -> list[str]:
    """Return the TOML files of the working folder that begin so; with nothing from here, shells complete paths."""
    if Path(incomplete).name != incomplete:
        return []
    return sorted(path.name for path in Path().glob("*.toml") if path.name.startswith(incomplete))
