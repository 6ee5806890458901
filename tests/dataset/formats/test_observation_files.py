from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dataset.toy import make_scene, observe
from warehouse_sim.dataset.formats.observation_files import ObservationFiles, SharedFile, image_amodal_mask


@pytest.mark.parametrize(
    ("offset", "expected"),
    [
        ((1, 0), [[0, 1, 1, 0], [0, 1, 0, 0], [0, 1, 1, 0]]),
        ((3, 2), [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]),
        ((-1, -1), [[0, 0, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0]]),
        ((-2, 0), [[0, 0, 0, 0]] * 3),
        ((4, 0), [[0, 0, 0, 0]] * 3),
        ((0, -5), [[0, 0, 0, 0]] * 3),
    ],
)
def test_amodal_mask_is_cut_at_the_image(offset: tuple[int, int], expected: list[list[int]]) -> None:
    annotation = replace(
        observe(make_scene(0))[0].annotations[0],
        amodal_mask_offset=offset,
        amodal_mask=np.array([[1, 1], [1, 0], [1, 1]], dtype=bool),
    )
    assert image_amodal_mask(annotation, (3, 4)).astype(int).tolist() == expected


def test_only_visible_targets_are_labelled_in_their_order() -> None:
    observation = observe(make_scene(0))[0]
    first, second, third = observation.annotations
    files = ObservationFiles(replace(observation, annotations=(first, replace(second, pixels_visible=0), third)))
    assert [target.annotation for target in files.targets] == [first, third]
    for target in files.targets:
        assert target.mask_visible.sum() == target.annotation.pixels_visible
        assert not (target.mask_visible & ~target.mask).any()


def test_shared_file_is_written_once_and_named_twice(tmp_path: Path) -> None:
    shared = SharedFile(b"content")
    for name in ("a", "b", "c"):
        shared.save(tmp_path / name)
    assert (tmp_path / "a").read_bytes() == b"content"
    assert (tmp_path / "a").samefile(tmp_path / "b")
    assert (tmp_path / "a").samefile(tmp_path / "c")
