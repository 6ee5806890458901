import numpy as np

from warehouse_sim.catalog.loads.film_skin import COLUMNS, Level, Sheet, film_skin, laid_on

SQUARE = np.array([[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]])


def sheet(rng: np.random.Generator, count: int, proud: float = 0.0) -> Sheet:
    column, height = np.sort(rng.uniform(0, COLUMNS, (2, count)), axis=1), rng.uniform(0.0, 1.0, (2, count))
    return Sheet(column, height, proud, rng.random(count) < 0.6 if count % 2 else None)


def test_sheets_laid_at_once_are_those_laid_point_by_point() -> None:
    rng = np.random.default_rng(3)
    skin = film_skin([Level(SQUARE, 0.0, 0.5), Level(SQUARE * 0.8, 0.5, 1.0)], 0.004, 0.7, rng)
    sheets = {"thin": [sheet(rng, 7), sheet(rng, 4, 0.001)], "none": [], "dense": [sheet(rng, 9, 0.004)]}
    meshes = laid_on(skin, sheets)
    assert list(meshes) == ["thin", "none", "dense"]
    assert len(meshes["none"].faces) == len(meshes["none"].vertices) == 0
    for name, group in sheets.items():
        triangles = []
        for item in group:
            low, high = (
                [skin.points(np.array([c]), np.array([h]), item.proud)[0] for c, h in zip(*line, strict=True)]
                for line in zip(item.column, item.height, strict=True)
            )
            spans = [
                i for i in range(len(low) - 1) if item.wide is None or item.wide[i] or item.wide[i + 1]
            ]  # what lies between two narrow places is left out
            triangles += [(low[i], low[i + 1], high[i + 1]) for i in spans]
            triangles += [(low[i], high[i + 1], high[i]) for i in spans]
        found = meshes[name].vertices[meshes[name].faces]
        np.testing.assert_array_equal(found, np.array(triangles).reshape(-1, 3, 3))
