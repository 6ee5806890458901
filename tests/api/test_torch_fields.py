from typing import Any

import numpy as np
import pytest

from warehouse_sim.api.dataset import Dataset
from warehouse_sim.api.observation.torch_fields import FIELDS
from warehouse_sim.errors import InputError, UnknownNameError

pytestmark = pytest.mark.gl


def batches(data: Dataset, *fields: str, workers: int = 0) -> list[dict[str, Any]]:
    from torch.utils.data import DataLoader

    return list(DataLoader(data.torch(*fields), 2, num_workers=workers))


def test_a_loader_batches_images_and_poses_by_itself(data: Dataset) -> None:
    found = batches(data, "rgb", "depth", "poses")
    most = max(len(obs.objects) for obs in data)
    assert len(found) == 3
    assert {len({len(obs.objects) for obs in data})} != {1}  # padding has something to do
    obs = data[5]
    last = {name: value[1].numpy() for name, value in found[2].items()}
    assert last["rgb"].shape == (3, *obs.depth.shape)
    assert np.array_equal(last["rgb"].transpose(1, 2, 0), obs.rgb)
    assert np.array_equal(last["depth"][0], obs.depth)
    assert last["poses"].shape == (most, 4, 4)
    assert last["poses"].dtype == np.float32
    assert last["valid"].tolist() == [number < len(obs.objects) for number in range(most)]
    assert np.allclose(last["poses"][last["valid"]], [item.T_camera_object for item in obs.objects], atol=1e-6)
    assert not last["poses"][~last["valid"]].any()
    assert (last["scene_id"], last["image_id"]) == (2, 1)


def test_every_field_is_batched_by_worker_processes(data: Dataset) -> None:
    (found,) = batches(data[:2], *FIELDS, workers=1)
    obs = data[1]
    values = {name: value[1].numpy() for name, value in found.items()}
    assert set(values) == {*FIELDS, "valid", "points_valid", "lidar_valid", "scene_id", "image_id"}
    assert np.array_equal(values["points"][values["points_valid"]], obs.points)
    assert np.array_equal(values["lidar"][values["lidar_valid"]], obs.lidar)
    assert np.array_equal(values["instance_mask"], obs.instance_mask)
    assert np.allclose(values["K"], obs.camera.K)
    for number, item in enumerate(obs.objects):
        assert np.array_equal(values["masks"][number], item.mask)
        assert np.array_equal(values["amodal_masks"][number], item.amodal_mask)
        assert np.allclose(values["boxes_3d"][number], item.box_3d, atol=1e-5)
        assert tuple(values["boxes_2d"][number]) == item.box_2d
        assert values["instance_ids"][number] == item.instance_id
        assert values["obj_ids"][number] == item.obj_id
        assert values["visible_fractions"][number] == pytest.approx(item.visible_fraction)


def test_without_names_it_holds_images_and_poses(data: Dataset) -> None:
    assert set(data.torch()[0]) == {"rgb", "depth", "poses", "valid", "scene_id", "image_id"}


def test_an_unknown_field_names_the_known_ones(data: Dataset) -> None:
    with pytest.raises(UnknownNameError, match=r"unknown field of observations 'rgbd'.*known: .*rgb"):
        data.torch("rgbd")
    with pytest.raises(InputError, match=r"fields\[0\] must be text, found 3"):
        data.torch(3)  # type: ignore[arg-type]
