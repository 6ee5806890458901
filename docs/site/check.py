"""Check a built site: no dead link or anchor, and nothing that a page loads lies elsewhere.

python -m docs.site.check build/docs
"""

import re
import sys
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

_ELSEWHERE = re.compile(r"^(?:https?:)?//")
_LOADED = {"script": "src", "img": "src", "iframe": "src", "source": "src", "video": "src", "audio": "src"}
_LOADING_LINKS = {"stylesheet", "icon", "preload", "preconnect", "dns-prefetch", "modulepreload"}
_CSS_URL = re.compile(r"(?:url\(\s*['\"]?|@import\s+['\"])((?:https?:)?//[^'\")\s]+)")


@dataclass
class Page(HTMLParser):
    """What one page links to, loads, and can be linked at."""

    anchors: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)
    loaded: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect from one tag."""
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag == "link" and _LOADING_LINKS & set(given.get("rel", "").split()):
            self.loaded.append(given.get("href", ""))
        if tag in _LOADED and given.get(_LOADED[tag]):
            self.loaded.append(given[_LOADED[tag]])


def read(path: Path) -> Page:
    """Return what a page holds."""
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page


def problems(root: Path) -> list[str]:
    """Return the dead links and what is loaded from elsewhere, one line each."""
    files = [path for path in sorted(root.rglob("*.html")) if "_static" not in path.parts]  # the theme's templates
    pages = {path.resolve(): read(path) for path in files}
    found = [] if pages else [f"{root}: holds no page"]
    for path, page in pages.items():
        where = path.relative_to(root.resolve())
        found += [f"{where}: loads {url} from elsewhere" for url in page.loaded if _ELSEWHERE.match(url)]
        local = [url for url in page.links + page.loaded if not urlsplit(url).scheme and not url.startswith("//")]
        found += [f"{where}: {url} is dead" for url in dict.fromkeys(local) if not _leads(path, url, pages)]
    for path in sorted(root.rglob("*.css")):
        text = path.read_text(encoding="utf-8")
        found += [f"{path.relative_to(root)}: loads {url} from elsewhere" for url in _CSS_URL.findall(text)]
    return found


def _leads(path: Path, url: str, pages: dict[Path, Page]) -> bool:
    parts = urlsplit(url)
    target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    if target.is_dir():
        target /= "index.html"
    if not target.is_file():
        return False
    return not parts.fragment or target not in pages or unquote(parts.fragment) in pages[target].anchors


def main() -> int:
    """Print the problems of the site that the command line names; exit code 1 where there are any."""
    found = problems(Path(sys.argv[1]))
    print("\n".join(found) if found else "no dead link, nothing loaded from elsewhere")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
