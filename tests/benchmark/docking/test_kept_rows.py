from pathlib import Path

from warehouse_sim.benchmark.docking.record import Kept


def test_rows_survive_a_line_that_was_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "new" / "rows.jsonl"
    kept = Kept(path)
    kept.add("a", {"n": 1})
    kept.add("b", {"n": 2})
    path.write_text(path.read_text()[:-7])  # killed while it wrote
    again = Kept(path)
    assert "a" in again
    assert "b" not in again
    again.add("c", {"n": 3})
    again.add("d", {"n": 4})
    last = Kept(path)
    assert [last[key]["n"] for key in "acd"] == [1, 3, 4]
