"""The web server of ``musclewire serve``: who may do what, what is sent to whom, and never a rig's timing.

Needs the extra ``live`` (FastAPI, uvicorn, websockets, httpx).
"""

from musclewire.errors import MissingExtraError

try:
    import fastapi
    import uvicorn
    import websockets
except ImportError:
    raise MissingExtraError("the live page", "live") from None

__all__ = ["fastapi", "uvicorn", "websockets"]
