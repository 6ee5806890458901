"""Pages read back by a strict parser, and opened in headless Chromium where there is one."""

import base64
import gzip
import json
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
_HOLD_IDLE_WORK = """
const [real, held] = [window.requestIdleCallback, []];
window.requestIdleCallback = (...work) => held.push(work);
window.release = () => { window.requestIdleCallback = real; held.forEach((work) => real(...work)); };
"""
SECONDS = 2.0
"""What a page may take of a processor until it is open."""
_SOFTWARE_GL = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


class Page(HTMLParser):
    """Collects tags, attributes, text and scripts, and checks that every opened element is closed in order."""

    VOID = frozenset({"meta", "img", "br", "input"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.words: list[str] = []
        self.data: list[Any] = []
        """What stands in scripts as JSON, packed or not."""
        self._open: list[str] = []
        self._is_data = self._is_packed = False
        self.feed(text)
        assert self._open == []

    @property
    def figures(self) -> list[dict[str, Any]]:
        """The charts, as Plotly takes them."""
        return [item for item in self.data if "layout" in item]

    @property
    def frames(self) -> list[dict[str, Any]]:
        """The frames of the gallery."""
        return [frame for item in self.data for frame in item.get("frames", ())]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]
        given = dict(attrs)
        self._is_data = given.get("type") == "application/json" or given.get("id") == "gallery-data"
        self._is_packed = given.get("type") == "application/gzip"
        if tag not in self.VOID:
            self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._open[-1:] != ["script"]:
            self.words.append(data)
        elif self._is_data:
            text = gzip.decompress(base64.b64decode(data)) if self._is_packed else data
            self.data.append(json.loads(text))


def needs_nothing_else(text: str) -> None:
    """Check that no element of a page names another file, and that its policy lets none be loaded."""
    page = Page(text)
    outside = [v for k, v in page.attributes if k in ("src", "href", "xlink:href") and not v.startswith(("data:", "#"))]
    assert outside == []
    own = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    assert not re.search(r"url\((?!#)|@import", own)
    assert "default-src 'none'" in own
    names = [value for name, value in page.attributes if name == "id"]
    assert len(names) == len(set(names)), "no two elements of a page share a name"
    assert {v[1:] for k, v in page.attributes if k == "href" and v.startswith("#")} <= set(names)


@contextmanager
def opened(path: Path, width: int = 1280) -> Iterator[Any]:
    """Yield a page in Chromium; afterwards, it must have requested nothing and complained of nothing."""
    playwright = pytest.importorskip("playwright.sync_api")
    if CHROMIUM is None:
        pytest.skip("no Chromium here")
    problems: list[str] = []
    with playwright.sync_playwright() as running:
        browser = running.chromium.launch(executable_path=CHROMIUM, args=_SOFTWARE_GL)
        page = browser.new_page(viewport={"width": width, "height": 900})
        session = page.context.new_cdp_session(page)
        session.send("Performance.setTimeDomain", {"timeDomain": "threadTicks"})
        session.send("Performance.enable")
        page.on("console", lambda item: problems.append(item.text) if item.type == "error" else None)
        page.on("pageerror", lambda item: problems.append(str(item)))
        page.on("request", lambda item: None if _is_own(item.url, path) else problems.append(item.url))
        page.add_init_script(_HOLD_IDLE_WORK)
        page.goto(path.as_uri())
        took = {item["name"]: item["value"] for item in session.send("Performance.getMetrics")["metrics"]}
        assert took["TaskDuration"] < SECONDS, "it opens at once"
        page.evaluate("release()")
        yield page
        browser.close()
    assert problems == []


def _is_own(url: str, path: Path) -> bool:
    return url.startswith(("data:", "blob:")) or url.partition("#")[0] == path.as_uri()
