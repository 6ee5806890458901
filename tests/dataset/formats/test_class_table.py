"""Values of class masks: the package's own numbers, and places from 1,000 on for classes with numbers of 31 bits."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from warehouse_sim.dataset.files.json_file import write_json
from warehouse_sim.dataset.formats.bop.exact_images import ClassTable, read_class_table, require_known_values
from warehouse_sim.errors import DatasetError
from warehouse_sim.schema.classes import CLASS_NUMBERS, class_number, mask_values

OWN = ("spoon", "crate of mine", "zebra")


def test_own_classes_fit_into_16_bits_and_others_keep_their_numbers() -> None:
    assert max(map(class_number, OWN)) > 65535
    values = mask_values([*OWN, "pallet", "outdoors", "spoon"])
    assert values["pallet"] == CLASS_NUMBERS["pallet"] == 1
    assert values["outdoors"] == CLASS_NUMBERS["outdoors"]
    assert sorted(values[name] for name in OWN) == [1000, 1001, 1002]
    assert sorted(OWN, key=values.__getitem__) == sorted(OWN, key=class_number)
    assert mask_values(reversed([*OWN, "pallet", "outdoors"])) == values
    assert max(CLASS_NUMBERS.values()) < 1000


def test_a_mask_and_its_table_say_the_class_of_each_pixel(tmp_path: Path) -> None:
    names = np.array([["", "pallet", "zebra"], ["spoon", "spoon", "floor"]])
    numbers = np.array([[class_number(name) if name else 0 for name in row] for row in names], np.int32)
    table = ClassTable([*OWN, "pallet", "floor"])
    image = cv2.imdecode(np.frombuffer(table.encode(numbers), np.uint8), cv2.IMREAD_UNCHANGED)
    assert image.dtype == np.uint16
    write_json(tmp_path / "scene_class_mask.json", table.rows)
    read = read_class_table(tmp_path / "scene_class_mask.json")
    assert [[read.get(int(value), "") for value in row] for row in image] == names.tolist()
    require_known_values(image, read, "here")
    with pytest.raises(DatasetError, match=r"here: holds 100\d, which scene_class_mask.json does not name"):
        require_known_values(image, {1: "pallet", 27: "floor"}, "here")
    with pytest.raises(DatasetError, match="is the number of no class of the scene"):
        ClassTable(["pallet"]).encode(numbers)


@pytest.mark.parametrize(
    ("row", "says"),
    [
        ({"class_name": "pallet", "class_number": 2}, "class_number is not that of 'pallet'"),
        ({"class_name": "pallet"}, "class_number"),
        ({"class_name": 3, "class_number": 1}, "class_name"),
        ([], "1"),
    ],
)
def test_a_malformed_table_is_rejected(tmp_path: Path, row: object, says: str) -> None:
    write_json(tmp_path / "t.json", {1: row})
    with pytest.raises(DatasetError, match=says):
        read_class_table(tmp_path / "t.json")
