"""The list of names that other rooms may use."""

from ._client import LiveClient as LiveClient
from ._messages import Command as Command
from ._messages import Reference as Reference
from ._server.application import LIVE as LIVE
from ._server.application import make_app as make_app
from ._server.session import Session as Session
from ._server.socket_messages import FromPage as FromPage
from ._server.socket_messages import ToPage as ToPage
