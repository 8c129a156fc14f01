"""The packages behind finite elements and drawings for a laser cutter, which the extra 'design' brings."""

from __future__ import annotations

from typing import Any

from musclewire.errors import require_extra


def require_finite_elements() -> Any:
    """Return scikit-fem. Raises MissingExtraError if it is not installed."""
    require_extra("sizing a part by finite elements", "design")
    import skfem

    return skfem


def require_dxf() -> Any:
    """Return ezdxf. Raises MissingExtraError if it is not installed."""
    require_extra("a drawing as DXF", "design")
    import ezdxf

    return ezdxf
