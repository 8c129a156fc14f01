"""The packages behind finite elements and drawings for a laser cutter, which the extra 'design' brings."""

from __future__ import annotations

from typing import Any

from musclewire.errors import MissingExtraError

EXTRA = "design"


def require_finite_elements() -> Any:
    """Return scikit-fem. Raises MissingExtraError if it is not installed."""
    try:
        import skfem
    except ImportError:
        raise MissingExtraError("sizing a part by finite elements", EXTRA) from None
    return skfem


def require_dxf() -> Any:
    """Return ezdxf. Raises MissingExtraError if it is not installed."""
    try:
        import ezdxf
    except ImportError:
        raise MissingExtraError("a drawing as DXF", EXTRA) from None
    return ezdxf
