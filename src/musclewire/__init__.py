"""Position and force control of shape-memory-alloy wires from their own electrical resistance.

    import musclewire as mw

    with mw.open_rig("simulated") as rig:
        loop = mw.characterize(rig)
        model = mw.fit(loop)
        run = mw.control(rig, model, mw.staircase())
    print(run.metrics)

Every name that is promised to users is here, and nothing else is promised: those of the core are listed in
``__init__.pyi``, those of parts outside the core in their manifests. Names are loaded when they are first used, so that
importing the package costs nothing.
"""

from __future__ import annotations

from typing import Any

import lazy_loader

_name_of_the_core, _names_of_the_core, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Load a name on first use; ``__version__`` is that of the installed package.

    Raises AttributeError for a name that nothing has, and for one whose part is not there, naming the part.
    """
    if name == "__version__":
        from importlib.metadata import version

        return version("musclewire")
    value = _name_of_the_core(name) if name in __all__ else _name_of_a_part(name)
    globals()[name] = value
    return value


def _name_of_a_part(name: str) -> Any:
    """Return a name that a part outside the core offers."""
    from musclewire.manifest import absent_part, loaded, offered

    place = None if name.startswith("_") else offered("names").get(name)
    if place is not None:
        return loaded(place)
    absent = absent_part("names", name)
    raise AttributeError(str(absent) if absent else f"module 'musclewire' has no attribute '{name}'")


def __dir__() -> list[str]:
    """Return the names of the core and of the parts that are there."""
    from musclewire.manifest import offered

    return sorted({*_names_of_the_core(), *offered("names")})
