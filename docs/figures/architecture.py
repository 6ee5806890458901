"""The rooms of the package and what each imports, read from the code: docs/images/architecture.png.

python -m docs.figures.architecture
"""

import ast
import tomllib
from collections import Counter
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = "warehouse_sim"


def floors() -> list[list[str]]:
    """Return the rooms from the bottom up, those of one floor together, as the import contract states them."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    layers = next(item["layers"] for item in contracts if item["name"] == "Imports run one way")
    return [[name.strip().removeprefix(f"{PACKAGE}.") for name in layer.split("|")] for layer in reversed(layers)]


def room_of(module: str) -> str:
    """Return the room of a module of the package."""
    return (module.removeprefix(PACKAGE).lstrip(".") or "__init__").split(".")[0]


@cache
def imports() -> Counter[tuple[str, str]]:
    """Return how many import statements lead from one room to another; those for type checkers alone count, too."""
    found: Counter[tuple[str, str]] = Counter()
    for path in sorted((ROOT / PACKAGE).rglob("*.py")):
        room = room_of(".".join(path.relative_to(ROOT).with_suffix("").parts))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            module = node.module if isinstance(node, ast.ImportFrom) else None
            if module and module.startswith(f"{PACKAGE}.") and room_of(module) != room:
                found[room, room_of(module)] += 1
    return found


def lines_of(room: str) -> int:
    """Return how many lines of code a room has."""
    folder = ROOT / PACKAGE / room
    files = folder.rglob("*.py") if folder.is_dir() else [folder.with_suffix(".py")]
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files)


def draw_architecture(path: Path) -> None:
    """Draw one row a room, from `cli` at the top: its size, and a mark under each room that it imports.

    Args:
        path: PNG to write.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    rooms = [room for floor in reversed(floors()) for room in floor]
    at = {room: index for index, room in enumerate(rooms)}
    figure, (size, grid) = plt.subplots(1, 2, figsize=(12, 9), sharey=True, gridspec_kw={"width_ratios": (1, 2.4)})
    size.barh(range(len(rooms)), [lines_of(room) / 1000 for room in rooms], color="#5b7fa6")
    size.set(xlabel="lines of code (thousands)", title="rooms", yticks=range(len(rooms)), yticklabels=rooms)
    size.invert_xaxis()
    size.yaxis.tick_right()
    size.invert_yaxis()
    for (user, used), count in imports().items():
        if user in at and used in at:
            grid.scatter(at[used], at[user], s=18 + 4 * min(count, 60), color="#c2562d", alpha=0.85, linewidths=0)
    grid.plot([-0.5, len(rooms) - 0.5], [-0.5, len(rooms) - 0.5], color="#999999", linewidth=0.8)
    grid.set_xticks(range(len(rooms)), rooms, rotation=60, ha="left")
    grid.xaxis.tick_top()
    grid.set_title("imports: the row uses the column; nothing below the diagonal", pad=78)
    grid.grid(color="#eeeeee")
    grid.set_axisbelow(True)
    grid.tick_params(axis="y", left=False)
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


if __name__ == "__main__":
    draw_architecture(ROOT / "docs" / "images" / "architecture.png")
