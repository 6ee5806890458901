import numpy as np
import pytest

from tests.evaluation.tables import missed, row, table, without_pockets
from warehouse_sim.errors import EvaluationError
from warehouse_sim.evaluation.error_table import read_table, write_table


def test_a_table_survives_its_file_with_infinities_and_nan(tmp_path):
    before = table(row(add=0.0123456, face="+y"), missed(scene_id=7), without_pockets())
    write_table(before, tmp_path / "errors.csv")
    after = read_table(tmp_path / "errors.csv")
    for name, column in before.columns().items():
        assert after.columns()[name].dtype.kind == column.dtype.kind, name
        if column.dtype.kind == "f":
            np.testing.assert_allclose(after.columns()[name], column, rtol=1e-6)
        else:
            assert after.columns()[name].tolist() == column.tolist()


def test_select_found_and_dockable():
    both = table(row(), missed(), without_pockets())
    assert both.found.tolist() == [True, False, True]
    assert both.dockable.tolist() == [True, True, False]
    assert len(both.select(both.found)) == 2
    assert both.slack[:2].tolist() == [0.030, -np.inf]


def test_what_stops_at_the_wrong_depth_has_no_clearance_and_does_not_dock():
    rows = table(row(), row(slack_depth=-0.001), row(slack_depth=-1e-10), row(slack_vertical=-0.001), without_pockets())
    assert rows.slack[:4].tolist() == [0.030, -np.inf, 0.030, -0.001]
    assert rows.docks().tolist() == [True, False, True, False, False]
    assert rows.docks(0.031).tolist() == [False] * 5


@pytest.mark.parametrize(
    "content",
    ["scene_id,image_id\n0,0\n", None, "scene_id\nx\n", "scene_id\n" + "9" * 30, "scene_id\n\0", "a" * 200_000],
)
def test_what_is_no_table_is_rejected_with_its_path(tmp_path, content):
    path = tmp_path / "errors.csv"
    if content is not None:
        path.write_text(content)
    with pytest.raises(EvaluationError, match=r"errors\.csv: is not a table"):
        read_table(path)
