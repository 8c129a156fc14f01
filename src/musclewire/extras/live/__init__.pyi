"""The list of names that other rooms may use."""

from ._client import LiveClient as LiveClient
from ._server.api_pages import markdown_page as markdown_page
from ._server.application import Limits as Limits
from ._server.application import make_app as make_app
from ._server.documents import openapi_document as openapi_document
from ._server.session import Session as Session
