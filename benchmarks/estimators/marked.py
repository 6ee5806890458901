"""Tables in documents that a command writes: they stand between two marks, the first of which names the command."""

from pathlib import Path

END = "<!-- end of table -->"


def replace_table(path: Path, command: str, table: str) -> Path:
    """Put ``table`` (Markdown) between the marks of ``command`` in the document ``path``.

    Raises:
        ValueError: The document has no such marks.
    """
    start = f"<!-- table: {command} -->"
    before, found, rest = path.read_text(encoding="utf-8").partition(start)
    _, ended, after = rest.partition(END)
    if not found or not ended:
        raise ValueError(f"{path}: has no lines {start!r} and {END!r}")
    path.write_text(f"{before}{start}\n\n{table}\n\n{END}{after}", encoding="utf-8")
    return path
