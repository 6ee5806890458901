"""Tables that a command writes into documents."""

import pytest

from benchmarks.estimators.table import replace_table


def test_a_table_is_replaced_between_its_marks_only(tmp_path):
    path = tmp_path / "page.md"
    end = "<!-- end of table -->"
    path.write_text(f"before\n<!-- table: one -->\nold\n{end}\nbetween\n<!-- table: two -->\nkept\n{end}\n")
    replace_table(path, "one", "new")
    text = path.read_text()
    assert "old" not in text
    assert [word for word in text.split() if word in ("before", "new", "between", "kept")] == [
        "before",
        "new",
        "between",
        "kept",
    ]
    with pytest.raises(ValueError, match="three"):
        replace_table(path, "three", "new")
