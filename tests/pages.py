"""HTML pages as a reader sees them: visible words, sections, and what is wrong with the markup."""

import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

from ehl.common.quantities import quantities

_VOID = {"meta", "br", "img", "link", "hr", "input"}
_HIDDEN = {"style", "script", "svg", "title"}


class Page(HTMLParser):
    """Visible words outside of figures, of all and of each section; faults of elements, names and links."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.source = path.read_text(encoding="utf-8")
        self.sections: list[str] = []
        self.faults: list[str] = []
        self._words: list[str] = []
        self._prose: list[str] = []
        self._open: list[str] = []
        self._names: Counter[str] = Counter()
        self._links: set[str] = set()
        self.feed(self.source)
        self.faults += [f"not closed: {tag}" for tag in self._open]
        self.faults += [f"twice: {name}" for name, count in self._names.items() if count > 1]
        self.faults += [f"link to nothing: {name}" for name in self._links - set(self._names)]
        self.text = _plain(self._words)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "section":
            self.sections.append("")
        for name, value in attrs:
            if name == "id" and value:
                self._names[value] += 1
            if name in ("href", "xlink:href") and value and value.startswith("#"):
                self._links.add(value[1:])
        if tag not in _VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in _VOID:
            self._open.pop()

    def handle_endtag(self, tag: str) -> None:
        if not self._open or self._open[-1] != tag:
            self.faults.append(f"{tag} ends inside of {self._open[-1:]}")
        elif self._open:
            self._open.pop()

    def handle_data(self, data: str) -> None:
        if not _HIDDEN & set(self._open):
            self._words.append(data)
            if "pre" not in self._open:
                self._prose.append(data)
            if self.sections:
                self.sections[-1] = _plain([self.sections[-1], data])

    @property
    def code_names(self) -> set[str]:
        """Names of quantities in the visible words outside of equations."""
        words = re.findall(r"\b[a-z]+(?:_[a-z0-9]+)+\b", _plain(self._prose))
        return {name for name in words if name in quantities()}


def read_page(path: Path) -> Page:
    """A page without faults of its markup, that refers to no other file and shows labels in place of names."""
    page = Page(path)
    assert page.faults == []
    assert not re.findall(r"""(?:src|href)\s*=\s*["'](?!#|data:)""", page.source)
    assert not re.findall(r"url\((?!#)", page.source)
    assert "@import" not in page.source
    assert page.code_names == set()
    return page


def _plain(words: list[str]) -> str:
    return re.sub(r"\s+", " ", " ".join(words)).strip()
