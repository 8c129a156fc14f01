"""What a page would fetch and what it is made of."""

from __future__ import annotations

from html.parser import HTMLParser


class Outside(HTMLParser):
    """Collects whatever a page would fetch from elsewhere, and the names of its elements."""

    def __init__(self) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            inside = name in {"href", "xlink:href"} and tag != "link" and (value or "").startswith("#")
            if name in {"src", "srcset", "action", "data", "href", "xlink:href"} and not inside:
                self.fetched.append(f"{tag} {name}={value}")
