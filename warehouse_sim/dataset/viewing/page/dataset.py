"""One page of a dataset's frames, for a browser without a network, as a file or served on the loopback address."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from warehouse_sim.dataset.reader import DatasetReader
from warehouse_sim.dataset.records import ImageRecord
from warehouse_sim.dataset.viewing.page.gallery import FRAMES, Shown, gallery
from warehouse_sim.dataset.viewing.page.template import filled
from warehouse_sim.errors import InputError

_LOOPBACK = "127.0.0.1"


def dataset_page(reader: DatasetReader, images: Sequence[ImageRecord], frames: int | None = FRAMES) -> bytes:
    """Return a page with pictures, depth, clouds, boxes and ways of a dataset's frames.

    Args:
        reader: The dataset.
        images: Which of its images.
        frames: How many frames at most; None for all.

    Raises:
        DatasetError: A file of the dataset is missing or malformed.
        MissingPackageError: jinja2 or plotly is not installed.
    """
    scenes, labels = len({image.scene_id for image in images}), sum(len(image.targets) for image in images)
    manifest = reader.manifest
    html = filled(
        __package__,
        "page.html.j2",
        title=reader.root.resolve().name,
        description="" if manifest is None else manifest.contents.description,
        items={"Scenes": scenes, "Images": len(images), "Labels": labels}
        | ({} if manifest is None else {"Recipe": reader.name, "Seed": manifest.seed}),
        frames=gallery([Shown(reader, images)], frames),
    )
    return html.encode("utf-8")


@contextmanager
def served(page: bytes, port: int) -> Iterator[ThreadingHTTPServer]:
    """Yield a server of a page on the loopback address; its ``serve_forever`` answers.

    Args:
        page: The HTML.
        port: Where it listens; 0 for any free port.

    Raises:
        InputError: The port is taken.
    """

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path != "/":
                self.send_error(404)
                return
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(page)))
            self.end_headers()
            self.wfile.write(page)

        def log_message(self, *_: object) -> None:
            """Say nothing of a request."""

    try:
        server = ThreadingHTTPServer((_LOOPBACK, port), Handler)
    except OSError as problem:
        raise InputError(f"--port {port}: cannot be listened on ({problem.strerror}); choose another one") from problem
    with server:
        yield server
