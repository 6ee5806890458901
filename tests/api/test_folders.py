import shutil
from pathlib import Path

import pytest

from warehouse_sim.api.dataset import Dataset
from warehouse_sim.api.folders import convert, validate
from warehouse_sim.errors import DatasetError, InputError, UnknownNameError

pytestmark = pytest.mark.gl


def test_a_good_dataset_is_told_from_a_damaged_one(smoke: Path, tmp_path: Path) -> None:
    good = validate(str(smoke))
    assert good
    assert good.ok
    assert "ok    manifest: " in repr(good)
    shutil.copytree(smoke, tmp_path / "bad")
    (tmp_path / "bad" / "scenes" / "000001.json").unlink()
    bad = validate(Dataset(tmp_path / "bad"))
    assert not bad
    assert "FAIL" in repr(bad)


def test_a_dataset_is_written_in_another_format(data: Dataset, tmp_path: Path) -> None:
    made = Dataset(convert(data, str(tmp_path / "made"), "linemod"))
    assert {obs.split for obs in made} == {"train", "val", "test"}
    assert (made[0].rgb == data[0].rgb).all()
    with pytest.raises(UnknownNameError, match="bopp"):
        convert(data, tmp_path / "other", ["bopp"])
    with pytest.raises(InputError, match="formats must be text or a list of text, found 3"):
        convert(data, tmp_path / "other", 3)  # type: ignore[arg-type]


def test_a_dataset_is_replaced_on_request_alone(data: Dataset, tmp_path: Path) -> None:
    made = tmp_path / "made"
    before = len(Dataset(convert(data, made, "linemod")))
    (made / "old.txt").write_text("old")
    with pytest.raises(DatasetError, match="not empty"):
        convert(data, made, "linemod")
    for wrong, kind, words in (
        (lambda: convert(made, made, "coco", overwrite=True), DatasetError, "holds the dataset that is read"),
        (lambda: convert(made, tmp_path, "coco", overwrite=True), DatasetError, "holds the dataset that is read"),
        (lambda: convert(data, made, "linemod", resume=True, overwrite=True), InputError, "give one of them"),
        (lambda: convert(data, made, "cocoo", overwrite=True), UnknownNameError, "did you mean 'coco'"),
    ):
        with pytest.raises(kind, match=words):
            wrong()
    assert len(Dataset(made)) == before
    assert len(Dataset(convert(data, made, "linemod", overwrite=True))) == before
    assert not (made / "old.txt").exists()


def test_a_dataset_without_sizes_of_objects_is_not_converted(smoke: Path, tmp_path: Path) -> None:
    (tmp_path / "theirs").symlink_to(smoke / "coco")
    with pytest.raises(DatasetError, match="does not say how large pallet is"):
        convert(tmp_path / "theirs", tmp_path / "made", "yolo")
    assert not (tmp_path / "made").exists()


def test_a_folder_that_is_not_there_is_said() -> None:
    with pytest.raises(DatasetError, match="nowhere: is not a folder"):
        validate("nowhere")
    with pytest.raises(InputError, match="data must be"):
        validate(3)  # type: ignore[arg-type]
